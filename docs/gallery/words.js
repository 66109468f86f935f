// words.js: what the viewer says about kinds of trees and types of nodes.
export const kinds = {
    h: {
        name: 'H-tree',
        text: 'Most nodes are two planes: where the left child ends and where the right one starts. Only where much '
            + 'empty space lies around a node does the cost model pay for a bounding node of two or six planes in '
            + 'front of it. Slide down and watch the red boxes close around what the blue ones leave open.',
    },
    ah: {
        name: 'AH-tree',
        text: 'An H-tree whose splits are found in a grid of counts, without touching a triangle. What is larger than '
            + 'a cell waits on a shelf: a node with a third child. The planes are nearly those of the H-tree, at a '
            + 'fraction of the work.',
    },
    skd: {
        name: 'Spatial kd-tree',
        text: 'The H-tree without its bounding nodes. Outer sides are never cut, so boxes stay large to the last '
            + 'level, and rays stray into empty space: the paper\u2019s reason to add bounding nodes.',
    },
    kd: {
        name: 'kd-tree',
        text: 'One plane divides space itself, so children never overlap and empty space can be cut off. What a '
            + 'plane cuts is in both children, so there are more references than triangles, and building takes longest.',
    },
    'bvh-sah': {
        name: 'BVH',
        text: 'Every node is a tight box of its own: six planes a node, of which most repeat what the parent has '
            + 'said. Children may overlap.',
    },
    'bvh-median': { name: 'BVH, spatial median', text: 'A box for every node, halved without asking what it costs.' },
    wide: {
        name: 'Wide tree',
        text: 'Eight children a node, up to eight triangles a leaf, so that vector units test eight boxes at once. '
            + 'Few levels, few nodes: compare the counts with the H-tree\u2019s.',
    },
    ug: {
        name: 'Uniform grid',
        text: 'No hierarchy at all: cells of one size. Quick to build, and blind to where the detail is. Show the '
            + 'empty cells to see what a ray has to step through.',
    },
};

const branch = '#3f7fbf', leaf = '#2f9e78', idle = '#98938a';

export const types = {
    empty: { name: 'empty', colour: idle, text: 'a leaf or cell without a triangle' },
    skd: { name: 'SKD node', colour: branch, text: 'two planes: the left child\u2019s end, the right child\u2019s start' },
    split: { name: 'split', colour: branch, text: 'one plane between two children' },
    box: { name: 'box', colour: branch, text: 'a box around its children' },
    leaf: { name: 'leaf', colour: leaf, text: 'triangles' },
    cell: { name: 'cell', colour: leaf, text: 'a cell that a triangle touches' },
    shelf: { name: 'SKD, shelf', colour: '#b05ac8', text: 'two planes, and a third child for what is large' },
    bv2: { name: 'BV2', colour: '#e08e1b', text: 'bounding node of two planes on one axis' },
    bv6: { name: 'BV6', colour: '#d3423a', text: 'bounding node of six planes' },
};
