// SPDX-License-Identifier: MIT

/* Compiled and never run: what must compile, and, after @ts-expect-error, what must not. */

import htree, {
    HTree, HTreeError, Hits, Counters, NONE, KINDS, STATUSES, libraryVersion,
} from 'htree';
import type { Hit, KindName, Mesh, Options, Stats } from 'htree';
import * as raw from 'htree/raw';

type Equal<A, B> = (<T>() => T extends A ? 1 : 2) extends (<T>() => T extends B ? 1 : 2)
    ? true : false;
const same = <A, B>(_: Equal<A, B>): void => undefined;

const mesh: Mesh = { positions: new Float32Array(9), indices: [0, 1, 2] };
const options: Options = { kind: 'h', threads: 1, strict: true, progress: (f) => f > 0.5 };
const tree = HTree.build(mesh, options);
const rays = new Float32Array(8);

same<typeof tree, HTree>(true);
const hits = tree.intersect(rays, { threads: 2, counters: new Counters(1), hits: new Hits(1) });
same<typeof hits, Hits>(true);
for (const hit of hits) same<typeof hit, Hit>(true);
const occluded = await tree.occludedAsync(rays, { occluded: new Uint8Array(1) });
occluded.fill(0);
const hit = tree.intersectRay([0, 0, 0], new Float32Array(3));
same<typeof hit, Hit | null>(true);
const stats: Stats = tree.stats();
const kind: KindName = stats.kind;
const number: number = KINDS[kind] + STATUSES.GEOMETRY + NONE + libraryVersion().length;
const built: HTree = await HTree.buildAsync(mesh, { kind: 3 });
const quality: number = tree.update(mesh, 'refit') + await tree.updateAsync(mesh, 'rebuild');
quality.toFixed();
tree.complete();
const measured = HTree.calibrate({ kind: 'ah' });
same<typeof measured.kind, KindName>(true);
HTree.build({ objects: { boxes: [], intersect: (object, ray) => ({ t: ray.tmin + object }) } });
HTree.build({ objects: { boxes: [], intersect: () => null } });
same<typeof htree.HTree, typeof HTree>(true);
const status: number = raw.htree_check(null);
{
    using scoped = HTree.build(mesh);
    scoped.check();
}

try {
    built.close();
} catch (error) {
    if (error instanceof HTreeError && error.code === 'GEOMETRY') {
        const words: string = error.words + error.message + number + status;
        words.trim();
    }
}

// @ts-expect-error no such kind
HTree.build(mesh, { kind: 'octree' });
// @ts-expect-error no such option
HTree.build(mesh, { thread: 1 });
// @ts-expect-error no such field
HTree.build({ vertices: [] });
// @ts-expect-error a worker hears no progress
HTree.buildAsync(mesh, { progress: () => false });
// @ts-expect-error nor does a query there
tree.intersectAsync(rays, { progress: () => false });
// @ts-expect-error no such way
tree.update(mesh, 'rest');
// @ts-expect-error doubles are no floats
tree.intersect(new Float64Array(8));
// @ts-expect-error build makes trees
new HTree();
// @ts-expect-error read-only
tree.closed = true;
// @ts-expect-error hits are no answers to occluded
tree.occluded(rays, { hits });
// @ts-expect-error three components
tree.intersectRay([0, 0], [0, 0, 1]);
