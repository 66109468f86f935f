// SPDX-License-Identifier: MIT
import { HTree } from 'htree';

const tree = HTree.build({
    positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1],
    indices: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
});
const hit = tree.intersectRay([2, 2, 2], [-1, -1, -1]);
console.log(hit ? `triangle ${hit.prim} at t = ${hit.t}` : 'miss');

const rays = new Float32Array([2, 2, 2, 0, -1, -1, -1, Infinity]);
const hits = await tree.intersectAsync(rays); // on a worker; tree.intersect(rays) waits
console.log(`${hits.count} ray, ${hits.isHit(0) ? 'hit' : 'missed'}`);
tree.close();
