// stage.js: boxes and triangles on a canvas, by three.js: a set of lines for each type and level of nodes, so that
// what is shown is a matter of switching them on.
import {
    BufferGeometry, Color, DirectionalLight, Float32BufferAttribute, HemisphereLight, Mesh, MeshLambertMaterial,
    PerspectiveCamera, Scene, Vector2, Vector3, WebGLRenderer, Group, DoubleSide,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';

// The corners of a box are numbered by bits: x, y, z.
const EDGES = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];

function addBox(points, box, at) {
    for (const corner of EDGES)
        for (let axis = 0; axis < 3; ++axis) points.push(box[at + axis + (corner >> axis & 1 ? 3 : 0)]);
}

// The edges of all boxes, by level.
function edgesByLevel({ level, box }) {
    const levels = new Map();
    level.forEach((l, i) => {
        if (!levels.has(l)) levels.set(l, []);
        addBox(levels.get(l), box, 6 * i);
    });
    return levels;
}

function lineMaterials(types) {
    const make = (colour, linewidth, opacity) =>
        new LineMaterial({ color: new Color(colour), linewidth, opacity, transparent: true, depthWrite: false });
    return Object.fromEntries(Object.entries(types).map(([type, { colour }]) =>
        [type, { level: make(colour, 1.8, 0.95), above: make(colour, 1, 0.28) }]));
}

function clear(group) {
    for (const child of [...group.children]) {
        child.geometry.dispose();
        group.remove(child);
    }
}

export function stage(canvas, types) {
    const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    const scene = new Scene(), camera = new PerspectiveCamera(38, 1, 0.01, 100);
    const lines = new Group(), solid = new Group();
    const materials = lineMaterials(types);
    const clay = new MeshLambertMaterial({ color: '#cfc8b8', side: DoubleSide, flatShading: true,
        polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const sun = new DirectionalLight('#ffffff', 1.6);
    const controls = new OrbitControls(camera, canvas);
    const calm = matchMedia('(prefers-reduced-motion: reduce)').matches;
    let waiting = false, visible = true;

    sun.position.set(2, 3, 1.5);
    scene.add(lines, solid, sun, new HemisphereLight('#ffffff', '#6d675c', 1.5));
    controls.enableDamping = true;
    controls.autoRotate = !calm;
    controls.autoRotateSpeed = 0.7;

    function paint() {
        controls.update();
        renderer.render(scene, camera);
    }

    // A picture is drawn when something has changed, and as long as the camera moves.
    function request() {
        if (waiting || !visible) return;
        waiting = true;
        requestAnimationFrame(() => {
            waiting = false;
            paint();
            if (controls.autoRotate) request();
        });
    }

    function resize() {
        const { clientWidth: width, clientHeight: height } = canvas;
        if (!width || !height) return;
        renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        renderer.setSize(width, height, false);
        for (const of of Object.values(materials))
            for (const material of Object.values(of)) material.resolution = new Vector2(width, height);
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
        request();
    }

    controls.addEventListener('change', request);
    controls.addEventListener('start', () => {
        controls.autoRotate = false;
    });
    new ResizeObserver(resize).observe(canvas);
    new IntersectionObserver(([entry]) => {
        visible = entry.isIntersecting;
        request();
    }).observe(canvas);

    // How far the corners of a box around the origin reach, of the way from the middle of the picture to its edge.
    function reach(half) {
        camera.lookAt(0, 0, 0);
        camera.updateMatrixWorld();
        const corners = [...Array(8).keys()].map((i) =>
            new Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1).multiply(half).project(camera));
        return Math.max(...corners.map(({ x, y }) => Math.max(Math.abs(x), Math.abs(y))));
    }

    // The scene is brought to the origin and to one size, so that light suits all of them, and the camera to where
    // it fills the picture.
    function frame(mesh) {
        mesh.geometry.computeBoundingBox();
        const center = mesh.geometry.boundingBox.getCenter(new Vector3());
        const half = mesh.geometry.boundingBox.getSize(new Vector3()).multiplyScalar(0.5);
        const size = half.length() || 1;
        for (const group of [lines, solid]) {
            group.scale.setScalar(1 / size);
            group.position.copy(center).multiplyScalar(-1 / size);
        }
        half.divideScalar(size);
        camera.position.set(1.7, 1.2, 2.1).setLength(4);
        for (let i = 0; i < 4; ++i) camera.position.multiplyScalar(reach(half) / 0.86);
        controls.target.set(0, 0, 0);
    }

    return {
        mesh(positions) {
            const geometry = new BufferGeometry();
            clear(solid);
            geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
            geometry.computeVertexNormals();
            solid.add(new Mesh(geometry, clay));
            frame(solid.children[0]);
        },
        tree(nodes) {
            clear(lines);
            for (const [type, boxes] of Object.entries(nodes)) {
                for (const [level, points] of edgesByLevel(boxes)) {
                    const set = new LineSegments2(new LineSegmentsGeometry().setPositions(points), materials[type].level);
                    set.userData = { type, level };
                    set.renderOrder = 1 + Object.keys(types).indexOf(type);
                    lines.add(set);
                }
            }
        },
        show({ level, only, mesh, hidden }) {
            solid.visible = mesh;
            for (const set of lines.children) {
                const { type, level: own } = set.userData;
                set.visible = !hidden.has(type) && (own === level || (!only && own < level));
                set.material = materials[type][own === level ? 'level' : 'above'];
            }
            request();
        },
        // Draws at once, and says how many pixels are not background, and a sum that another picture would not have.
        probe() {
            controls.autoRotate = false;
            paint();
            const gl = renderer.getContext();
            const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
            const pixels = new Uint8Array(4 * width * height);
            let drawn = 0, sum = 0;
            gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
            for (let i = 0; i < pixels.length; ++i) {
                sum = (Math.imul(sum, 31) + pixels[i]) | 0;
                if (i % 4 === 3 && pixels[i]) ++drawn;
            }
            return { drawn, sum, width, height };
        },
    };
}
