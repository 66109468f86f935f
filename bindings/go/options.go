// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import "unsafe"

// A BuildOption says how to build.
type BuildOption interface{ applyBuild(*buildConfig) }

// A QueryOption says how to query.
type QueryOption interface{ applyQuery(*queryConfig) }

// A LoadOption says how to load.
type LoadOption interface{ applyLoad(*loadConfig) }

// An Option is for builds and for queries.
type Option interface {
	BuildOption
	QueryOption
}

// A TreeOption is for builds and for loads.
type TreeOption interface {
	BuildOption
	LoadOption
}

// An AnyOption is for builds, loads and queries.
type AnyOption interface {
	Option
	LoadOption
}

type buildConfig struct {
	kind   Kind
	set    []func(*cOptions) // after the kind's defaults
	hooks  hooks
	report func(float64) bool
}

type loadConfig struct {
	threads uint32
	hooks   hooks
}

type queryConfig struct {
	threads  *uint32
	counters []Counters
	counting bool
	report   func(float64) bool
}

type buildOption func(*buildConfig)

func (o buildOption) applyBuild(c *buildConfig) { o(c) }

type loadOption func(*loadConfig)

func (o loadOption) applyLoad(c *loadConfig) { o(c) }

// A hookOption sets hooks of a tree, whether it is built or loaded.
type hookOption func(*hooks)

func (o hookOption) applyBuild(c *buildConfig) { o(&c.hooks) }
func (o hookOption) applyLoad(c *loadConfig)   { o(&c.hooks) }

type queryOption func(*queryConfig)

func (o queryOption) applyQuery(c *queryConfig) { o(c) }

type threads uint32

func (n threads) applyBuild(c *buildConfig) {
	c.set = append(c.set, func(o *cOptions) { o.threads = C.uint32_t(n) })
}

func (n threads) applyLoad(c *loadConfig) { c.threads = uint32(n) }

func (n threads) applyQuery(c *queryConfig) {
	count := uint32(n)
	c.threads = &count
}

type progressFunc func(float64) bool

func (f progressFunc) applyBuild(c *buildConfig) { c.report = f }
func (f progressFunc) applyQuery(c *queryConfig) { c.report = f }

// WithThreads uses all cores for 0, the calling thread for 1, at most n for n. The threads of a
// build or load are those of its tree's queries too, unless they say otherwise.
func WithThreads(n uint32) AnyOption { return threads(n) }

// WithProgress calls report with the share that is done, on the calling goroutine; false cancels the call.
func WithProgress(report func(fraction float64) bool) Option { return progressFunc(report) }

// WithCounters writes there what each ray cost, one for each ray. Counting costs a little time.
func WithCounters(counters []Counters) QueryOption {
	return queryOption(func(c *queryConfig) { c.counters, c.counting = counters, true })
}

// WithKind builds that structure, with its defaults; Balanced without it.
func WithKind(kind Kind) BuildOption {
	return buildOption(func(c *buildConfig) { c.kind = kind })
}

func set(change func(*cOptions)) BuildOption {
	return buildOption(func(c *buildConfig) { c.set = append(c.set, change) })
}

func setFlag(flag C.uint32_t) BuildOption {
	return set(func(o *cOptions) { o.flags |= flag })
}

// WithStrict refuses NaN, infinite and oversize coordinates instead of skipping them.
func WithStrict() BuildOption { return setFlag(C.HTREE_STRICT) }

// WithAnyPlanes lets H and AH use bounding nodes of any of 63 sets of planes.
func WithAnyPlanes() BuildOption { return setFlag(C.HTREE_ANY_PLANES) }

// WithLoosePlanes lets AH use planes as the grid gives them, half a cell wide.
func WithLoosePlanes() BuildOption { return setFlag(C.HTREE_LOOSE_PLANES) }

// WithMorton lets Wide use Morton order below the grid: faster to build, slower to trace.
func WithMorton() BuildOption { return setFlag(C.HTREE_MORTON) }

// WithLazy lets Wide build only the top, and the rest by the first ray that gets there, from a copy of the
// mesh that the tree holds until it is complete; see [Tree.Complete].
func WithLazy() BuildOption { return setFlag(C.HTREE_LAZY) }

// WithCompact lets Wide take less than half of the memory: slower to build and to trace, and not WithLazy.
func WithCompact() BuildOption { return setFlag(C.HTREE_COMPACT) }

// WithCollapse collapses the finished tree of a BVH, SKD, H or AH into one of kind Wide; Best does so.
func WithCollapse() BuildOption { return setFlag(C.HTREE_COLLAPSE) }

// WithBuckets evaluates cost at n - 1 planes along an axis, 2 to 64.
func WithBuckets(n uint32) BuildOption {
	return set(func(o *cOptions) { o.buckets = C.uint32_t(n) })
}

// WithAxes splits along the widest extent of centroids only for 1, and tries all axes for 3.
func WithAxes(n uint32) BuildOption {
	return set(func(o *cOptions) { o.axes = C.uint32_t(n) })
}

// WithCellsPerPrim sets the cells of the AH-tree's grid for each triangle, 1/64 to 64.
func WithCellsPerPrim(cells float32) BuildOption {
	return set(func(o *cOptions) { o.cells_per_prim = C.float(cells) })
}

// WithFewPrims builds ranges of no more than n triangles as an H-tree, 1 to 2^20.
func WithFewPrims(n uint32) BuildOption {
	return set(func(o *cOptions) { o.few_prims = C.uint32_t(n) })
}

// WithTasks runs parallel loops by a function of yours in place of the library's threads, for the build and
// for the queries of its tree. run calls task(i) for every 0 <= i < count, from any goroutines, and
// returns when all are done. What it leaves out is done after it; what it calls twice is done once.
func WithTasks(run func(count uint32, task func(index uint32))) TreeOption {
	return hookOption(func(h *hooks) { h.tasks = run })
}

// WithAllocator takes memory for the build or the load and its tree from there.
func WithAllocator(allocator Allocator) TreeOption {
	return hookOption(func(h *hooks) { h.allocator = allocator })
}

// WithIntersect intersects the objects of a tree that is loaded: as Objects.Intersect does.
func WithIntersect(intersect func(object uint32, ray Ray) (t, u, v float32, ok bool)) LoadOption {
	return loadOption(func(c *loadConfig) { c.hooks.intersect = intersect })
}

// Costs are those of section 6.3 of the paper, in any common unit.
type Costs struct {
	SKD       float32 // C_SKD^T, traversing a node with two separating planes
	BV2       float32 // C_2PN^T, clipping by two planes
	BV6       float32 // C_6PN^T, clipping by six planes
	Intersect float32 // C_IT, one test of a triangle or an object
}

// WithCosts builds for these costs.
func WithCosts(costs Costs) BuildOption {
	return set(func(o *cOptions) {
		o.cost_skd, o.cost_bv2 = C.float(costs.SKD), C.float(costs.BV2)
		o.cost_bv6, o.cost_intersect = C.float(costs.BV6), C.float(costs.Intersect)
	})
}

// Calibrate measures the costs on this machine, in some milliseconds, in units of SKD. What it finds
// depends on timing, and so will a tree built for it; the hits will not.
func Calibrate() (Costs, error) {
	options, err := (&buildConfig{kind: Balanced}).options()
	if err == nil {
		err = rawCalibrate(&options)
	}
	if err != nil {
		return Costs{}, err
	}
	return Costs{float32(options.cost_skd), float32(options.cost_bv2), float32(options.cost_bv6),
		float32(options.cost_intersect)}, nil
}

// options are the kind's defaults and what was set after them, without hooks.
func (c *buildConfig) options() (cOptions, error) {
	var options cOptions
	if err := rawOptionsInit(&options, unsafe.Sizeof(options), c.kind); err != nil {
		return options, err
	}
	for _, change := range c.set {
		change(&options)
	}
	return options, nil
}
