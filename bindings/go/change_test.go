// SPDX-License-Identifier: MIT

package htree

import (
	"bytes"
	"errors"
	"math"
	"runtime"
	"runtime/debug"
	"strings"
	"sync"
	"testing"
	"time"
)

const side = 60

// lifted has the same triangles, each vertex a little higher.
func lifted(mesh Mesh) Mesh {
	positions := append([]float32(nil), mesh.Positions...)
	for i := 0; i < len(positions); i += 3 {
		positions[i+2] += 0.02 * positions[i]
	}
	mesh.Positions = positions
	return mesh
}

func answersAs(t *testing.T, tree *Tree, mesh Mesh) {
	t.Helper()
	if err := tree.Check(); err != nil {
		t.Fatal(err)
	}
	rays, other := raysDown(side, 3000), build(t, mesh, WithKind(BVHSAH))
	sameHits(t, intersect(t, tree, rays), intersect(t, other, rays), "against a new tree")
	if got, want := must[Box](t)(tree.Bounds()), must[Box](t)(other.Bounds()); got != want {
		t.Fatal(got, want)
	}
}

func subtrees(t *testing.T, tree *Tree) (left, built uint64) {
	stats := must[Stats](t)(tree.Stats())
	return stats.Subtrees, stats.SubtreesBuilt
}

// nodes are a copy.
func nodes(t *testing.T, tree *Tree) (nodes []byte) {
	err := tree.View(func(view View) error {
		nodes = append(append(nodes, view.Nodes...), view.Leaves...)
		return nil
	})
	if err != nil {
		t.Fatal(err)
	}
	return nodes
}

func TestRaysBuildALazyTreeAndCompleteBuildsTheRest(t *testing.T) {
	mesh := terrain(side)
	lazy, eager := build(t, mesh, WithLazy()), build(t, mesh, WithMorton())
	left, built := subtrees(t, lazy)
	if none, _ := subtrees(t, eager); left < 10 || built != 0 || none != 0 {
		t.Fatal(left, built, none)
	}
	must[Hit](t)(lazy.IntersectOne(NewRay([3]float32{1.3, 1.4, 5}, [3]float32{0, 0, -1})))
	if _, built = subtrees(t, lazy); built == 0 || built >= left {
		t.Errorf("one ray built %d of %d subtrees", built, left)
	}
	if err := lazy.View(func(View) error { return nil }); !errors.Is(err, ErrUnsupported) {
		t.Error(err)
	}
	answersAs(t, lazy, mesh)
	for i := 0; i < 2; i++ {
		if err := lazy.Complete(); err != nil {
			t.Fatal(err)
		}
	}
	if left, _ = subtrees(t, lazy); left != 0 || lazy.borrowed.copied {
		t.Error(left, "subtrees are left, or the copy of the mesh")
	}
	if !bytes.Equal(nodes(t, lazy), nodes(t, eager)) {
		t.Error("the complete tree has other bytes than that of Morton order")
	}
	answersAs(t, lazy, mesh)
}

func TestCompactTreesAnswerAlikeInLessThanHalfOfTheMemory(t *testing.T) {
	mesh := terrain(side)
	compact, whole := build(t, mesh, WithKind(Wide), WithCompact()), build(t, mesh, WithKind(Wide))
	less, all := must[Stats](t)(compact.Stats()).Bytes, must[Stats](t)(whole.Stats()).Bytes
	if 2*less >= all {
		t.Errorf("%d bytes, and %d as ever", less, all)
	}
	if err := compact.View(func(View) error { return nil }); !errors.Is(err, ErrUnsupported) {
		t.Error(err)
	}
	answersAs(t, compact, mesh)
	back := must[*Tree](t)(Load(must[[]byte](t)(compact.Save())))
	t.Cleanup(func() { back.Close() })
	answersAs(t, back, mesh)
	next := lifted(mesh)
	if quality := must[float64](t)(compact.Update(next, Refit)); quality != 1 {
		t.Error(quality, "of a tree that was rebuilt")
	}
	answersAs(t, compact, next)
	if _, err := Build(mesh, WithCompact(), WithLazy()); !errors.Is(err, ErrArgument) {
		t.Error(err)
	}
}

func TestCollapsedTreesAreWide(t *testing.T) {
	mesh := terrain(side)
	for _, kind := range []Kind{BVHMedian, AH} {
		plain, collapsed := build(t, mesh, WithKind(kind)), build(t, mesh, WithKind(kind), WithCollapse())
		if got := must[Stats](t)(plain.Stats()).Kind; got != kind {
			t.Error(got, "is not", kind)
		}
		if got := must[Stats](t)(collapsed.Stats()).Kind; got != Wide {
			t.Error(kind, "was collapsed to", got)
		}
		answersAs(t, collapsed, mesh)
	}
	if got := must[Stats](t)(build(t, mesh, WithKind(Best)).Stats()).Kind; got != Wide {
		t.Error("the preset built", got)
	}
}

func TestALazyTreeReadsNothingOfGosAfterBuild(t *testing.T) {
	mesh := terrain(side)
	want := terrain(side)
	lazy := build(t, mesh, WithLazy())
	for i := range mesh.Positions {
		mesh.Positions[i] = float32(math.NaN())
	}
	for i := range mesh.Indices {
		mesh.Indices[i] = math.MaxUint32
	}
	mesh = Mesh{}
	runtime.GC()
	answersAs(t, lazy, want)
	next := lifted(want)
	must[float64](t)(lazy.Update(next, Rebuild))
	for i := range next.Positions {
		next.Positions[i] = 0
	}
	answersAs(t, lazy, lifted(want))
}

func TestGoroutinesMeetInALazyTree(t *testing.T) {
	mesh, rays := terrain(side), raysDown(side, 5000)
	want := intersect(t, build(t, mesh), rays)
	for round := 0; round < 20; round++ {
		lazy := build(t, mesh, WithLazy())
		var group sync.WaitGroup
		for i := 0; i < 4; i++ {
			group.Add(1)
			go func(i int) {
				defer group.Done()
				hits := make([]Hit, len(rays))
				if i == 3 {
					if err := lazy.Complete(); err != nil {
						t.Error(err)
					}
				}
				if err := lazy.Intersect(rays, hits); err != nil || hits[7] != want[7] {
					t.Error(err, hits[7], want[7])
				}
			}(i)
		}
		group.Wait()
		sameHits(t, intersect(t, lazy, rays), want, "round %d", round)
	}
}

func TestLazyTreesLeaveNothingBehind(t *testing.T) {
	mesh := terrain(200) // a copy is 1.4 MB
	bad := mesh
	bad.Indices = append(append([]uint32(nil), mesh.Indices...), 0, 1, math.MaxUint32)
	tree := build(t, mesh, WithLazy())
	for name, step := range map[string]func() error{
		"update":         func() error { _, err := tree.Update(mesh, Rebuild); return err },
		"refused update": func() error { _, err := tree.Update(bad, Rebuild); return err },
		"refused build":  func() error { return buildError(bad, WithLazy()) },
		"build": func() error {
			tree, err := Build(mesh, WithLazy())
			tree.Close()
			return err
		},
	} {
		round := func(count int) {
			for i := 0; i < count; i++ {
				if err := step(); (err != nil) != strings.HasPrefix(name, "refused") {
					t.Fatal(name, err)
				}
			}
			debug.FreeOSMemory()
		}
		round(20)
		before := residentBytes(t)
		round(100)
		if growth := residentBytes(t) - before; growth > 64<<20 {
			t.Errorf("%d bytes more after 100 times %s", growth, name)
		}
	}
}

func TestEveryKindAnswersAsANewTreeAfterUpdates(t *testing.T) {
	for kind := UG; kind <= Wide; kind++ {
		mesh := terrain(side)
		tree := build(t, Mesh{}, WithKind(kind))
		for _, how := range []How{Rebuild, Refit, Refit, Rebuild} {
			mesh = lifted(mesh)
			quality := must[float64](t)(tree.Update(mesh, how))
			if how == Rebuild && quality != 1 || quality < 0.2 || quality > 20 {
				t.Error(kind, how, quality)
			}
			answersAs(t, tree, mesh)
		}
	}
}

func TestRefittingKeepsTheNodes(t *testing.T) {
	mesh := terrain(side)
	tree := build(t, mesh)
	address := func() (address *byte) {
		tree.View(func(view View) error { address = &view.Nodes[0]; return nil })
		return address
	}
	before := address()
	if quality := must[float64](t)(tree.Update(lifted(mesh), Refit)); quality == 1 || address() != before {
		t.Error("it was rebuilt: ", quality)
	}
}

func TestAMeshThatIsRefusedLeavesTheTreeAsItWas(t *testing.T) {
	mesh := terrain(side)
	few, odd, stride := mesh, mesh, mesh
	few.Positions, odd.Indices, stride.PositionStride = mesh.Positions[:9], mesh.Indices[:4], 8
	for _, options := range [][]BuildOption{nil, {WithLazy()}} {
		tree := build(t, mesh, options...)
		for _, how := range []How{Refit, Rebuild, 0, 3} {
			for _, bad := range []Mesh{few, odd, stride} {
				quality, err := tree.Update(bad, how)
				if !errors.Is(err, ErrGeometry) && !errors.Is(err, ErrArgument) || quality != 0 {
					t.Error(how, quality, err)
				}
			}
		}
		if _, err := tree.Update(mesh, 3); !errors.Is(err, ErrArgument) {
			t.Error(err)
		}
		answersAs(t, tree, mesh)
	}
}

func TestObjectsAreThoseOfTheLastUpdate(t *testing.T) {
	tree := build(t, Mesh{}, WithKind(Wide))
	for i, how := range []How{Rebuild, Refit, Rebuild} {
		at := float32(90 + i)
		objects := shelves(1)
		objects.Intersect = func(uint32, Ray) (t, u, v float32, ok bool) { return at, 0, 0, true }
		must[float64](t)(tree.Update(Mesh{Objects: objects}, how))
		if hit := must[Hit](t)(tree.IntersectOne(down)); hit.T != at {
			t.Error(hit, at)
		}
		bad := Mesh{Positions: make([]float32, 9), Indices: []uint32{0, 1, 99}}
		if _, err := tree.Update(bad, how); !errors.Is(err, ErrGeometry) {
			t.Error(err)
		}
		if hit := must[Hit](t)(tree.IntersectOne(down)); hit.T != at {
			t.Error("after an error: ", hit, at)
		}
	}
	must[float64](t)(tree.Update(Mesh{}, Rebuild))
	if hit := must[Hit](t)(tree.IntersectOne(down)); hit.IsHit() || tree.hooks.intersect != nil {
		t.Error(hit)
	}
}

func TestPanicsOfHooksComeOutOfUpdates(t *testing.T) {
	mesh, moody := terrain(side), false
	tasks := func(count uint32, task func(uint32)) {
		if moody {
			panic("of a hook")
		}
		for i := uint32(0); i < count; i++ {
			task(i)
		}
	}
	tree := build(t, mesh, WithTasks(tasks))
	for _, how := range []How{Refit, Rebuild} {
		mesh, moody = lifted(mesh), true
		func() {
			defer func() {
				if value := recover(); value != "of a hook" {
					t.Error(how, value)
				}
			}()
			tree.Update(mesh, how)
		}()
		moody = false
		answersAs(t, tree, mesh)
	}
}

func TestUpdatesAndQueriesWaitForEachOther(t *testing.T) {
	forms := []Mesh{terrain(20), lifted(terrain(20))}
	rays := raysDown(20, 3000)
	want := [][]Hit{intersect(t, build(t, forms[0]), rays), intersect(t, build(t, forms[1]), rays)}
	same := func(a, b []Hit) bool {
		for i := range a {
			if a[i] != b[i] {
				return false
			}
		}
		return true
	}
	tree := build(t, forms[0])
	stop := make(chan bool)
	var group sync.WaitGroup
	for i := 0; i < 3; i++ {
		group.Add(1)
		go func() {
			defer group.Done()
			hits := make([]Hit, len(rays))
			for {
				select {
				case <-stop:
					return
				default:
				}
				if err := tree.Intersect(rays, hits); err != nil || !same(hits, want[0]) && !same(hits, want[1]) {
					t.Error("hits of neither form: ", err)
					return
				}
				time.Sleep(time.Millisecond)
			}
		}()
	}
	for i := 1; i < 200; i++ {
		must[float64](t)(tree.Update(forms[i%2], []How{Refit, Rebuild}[i/2%2]))
	}
	close(stop)
	group.Wait()
	sameHits(t, intersect(t, tree, rays), want[1], "after the last update")
}

func TestClosingWhileUpdatesRunIsSafe(t *testing.T) {
	mesh := terrain(20)
	for round := 0; round < 50; round++ {
		tree := build(t, mesh, WithLazy())
		var group sync.WaitGroup
		for i := 0; i < 3; i++ {
			group.Add(1)
			go func() {
				defer group.Done()
				for {
					if _, err := tree.Update(mesh, Refit); err != nil {
						if !errors.Is(err, ErrClosed) {
							t.Error(err)
						}
						return
					}
				}
			}()
		}
		time.Sleep(time.Millisecond)
		tree.Close()
		group.Wait()
		if tree.tree != nil || tree.borrowed.copied {
			t.Fatal("the last update did not free the tree")
		}
	}
}
