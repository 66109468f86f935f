// SPDX-License-Identifier: MIT
'use strict';

/* A mesh as the struct that C reads. Typed arrays are handed over as they lie. */

const { types } = require('node:util');
const callbacks = require('./callbacks');
const { floatsOf, steady } = require('./batches');
const { requireNames, requireUint32 } = require('./options');

const NAMES = ['positions', 'positionStride', 'indices', 'triangleCount', 'objects'];
const VERTEX_BYTES = 12;
const BOX_FLOATS = 6;

function indicesOf(values) {
    if (types.isUint32Array(values)) return values;
    if (types.isUint16Array(values) || types.isInt32Array(values)) return Uint32Array.from(values);
    if (!Array.isArray(values)) throw new TypeError('indices must be a Uint32Array or an array');
    return Uint32Array.from(values, (value) => requireUint32(value, 'an index'));
}

function countVertices(positions, stride) {
    if (stride === 0 && positions.length % 3 !== 0) {
        throw new RangeError(`positions hold ${positions.length} floats: a vertex has 3`);
    }
    if (positions.byteLength < VERTEX_BYTES) return 0;
    return Math.floor((positions.byteLength - VERTEX_BYTES) / (stride || VERTEX_BYTES)) + 1;
}

function countTriangles(given, indices, vertexCount) {
    if (indices && indices.length % 3 !== 0) {
        throw new RangeError(`indices hold ${indices.length} numbers: a triangle has 3`);
    }
    const there = Math.floor(indices ? indices.length / 3 : vertexCount / 3);
    if (given === undefined) return there;
    requireUint32(given, 'triangleCount');
    // Only the library can say that there are too few vertices; indices it cannot count.
    if (indices && given > there) throw new RangeError(`triangleCount is ${given} of ${there}`);
    return given;
}

function objectsOf(objects) {
    if (objects == null) return null;
    requireNames(objects, ['boxes', 'intersect'], 'objects');
    const { boxes: given, intersect } = objects;
    if (typeof intersect !== 'function') {
        throw new TypeError('objects.intersect must be a function');
    }
    const boxes = types.isFloat32Array(given) ? given : floatsOf(given, 'objects.boxes');
    if (boxes.length % BOX_FLOATS !== 0) {
        throw new RangeError(`objects.boxes hold ${boxes.length} floats: a box has ${BOX_FLOATS}`);
    }
    return boxes.length === 0 ? null : { boxes, intersect };
}

/** {arrays, stride, counts} of a mesh, checked; `copy`: JavaScript will run while C reads. */
function read(mesh, copy) {
    requireNames(mesh, NAMES, 'a mesh');
    const keep = copy ? steady : (array) => array;
    const given = mesh.positions ?? [];
    const positions = types.isFloat32Array(given) ? given : floatsOf(given, 'positions');
    const indices = mesh.indices == null ? null : indicesOf(mesh.indices);
    const stride = requireUint32(mesh.positionStride ?? 0, 'positionStride');
    const vertexCount = countVertices(positions, stride);
    const objects = objectsOf(mesh.objects);
    return {
        positions: keep(positions),
        stride,
        vertexCount,
        indices: keep(indices),
        triangleCount: countTriangles(mesh.triangleCount, indices, vertexCount),
        objects: objects && { boxes: keep(objects.boxes), intersect: objects.intersect },
    };
}

/** The struct; `key` names the objects' callback, if there are objects. */
function toStruct(mesh, key) {
    return {
        positions: mesh.positions,
        position_stride: mesh.stride,
        vertex_count: mesh.vertexCount,
        indices: mesh.indices,
        triangle_count: mesh.triangleCount,
        objects: mesh.objects && {
            boxes: mesh.objects.boxes,
            count: mesh.objects.boxes.length / BOX_FLOATS,
            intersect: callbacks.intersect,
            user: key,
        },
        reserved: [0, 0],
    };
}

module.exports = { read, toStruct };
