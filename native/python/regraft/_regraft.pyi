"""The native half of regraft; use it through `import regraft`."""

# Written by tests/make_stub.py.

from collections.abc import Callable, Sequence
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from regraft.camera import Camera
from regraft.light import Light

__version__: str

class Frame:
    """A rendered picture and what it cost."""
    @property
    def passes(self) -> dict[str, npt.NDArray[np.float32]]:
        """The passes asked for: (H, W, C) float32, first row on top; `[::-1]` is C-contiguous."""
    @property
    def statistics(self) -> FrameStatistics:
        """What it cost; the same object at every access."""
    @property
    def cancelled(self) -> bool:
        """True if `cancel` ended it: finished tiles are there, the rest is transparent."""

class FrameStatistics:
    """What a frame cost. The host adds `frame`, `evaluate_ms`, `extract_ms` and `write_ms`."""

    frame: int
    evaluate_ms: float
    extract_ms: float
    update_ms: float
    trace_ms: float
    shade_ms: float
    write_ms: float
    @property
    def total_ms(self) -> float:
        """sum of all of the above"""
    policy: str
    structure: str
    layout: str
    triangles: int
    instances: int
    moved_instances: int
    deformed_meshes: int
    deformed_triangles: int
    nodes: int
    nodes_refitted: int
    nodes_rebuilt: int
    pairs_considered: int
    pairs_restructured: int
    late_updates: int
    late_update_ms: float
    rays_primary: int
    rays_shadow: int
    rays_secondary: int
    nodes_visited: int
    triangle_tests: int
    culling_efficiency: float
    observed_cost: float
    cost_ratio: float
    kdtree_nodes: int
    kdtree_built_fraction: float
    kdtree_unbuilt_nodes: int
    kdtree_large_leaves: int
    memory_bytes: int
    left_out: list[str]
    warnings: list[str]
    def as_dict(self) -> dict[str, Any]:
        """All of it as a dict of plain Python values, in the order of the statistics line."""
    def __repr__(self) -> str: ...

class HitBatch:
    """Nearest hits of N rays, one element a ray."""
    @property
    def t(self) -> npt.NDArray[np.float32]:
        """(N,) float32, in units of the direction's length; inf: a miss."""
    @property
    def instance_id(self) -> npt.NDArray[np.uint32]:
        """(N,) uint32; 0xFFFFFFFF: a miss."""
    @property
    def prim_id(self) -> npt.NDArray[np.uint32]:
        """(N,) uint32, the triangle of the instance's mesh; 0xFFFFFFFF: a miss."""
    @property
    def u(self) -> npt.NDArray[np.float32]:
        """(N,) float32, weight of the triangle's second vertex."""
    @property
    def v(self) -> npt.NDArray[np.float32]:
        """(N,) float32, weight of the triangle's third vertex."""
    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """(N, 3) float32, geometric unit normal in the world frame, facing as the placed triangle
        is wound; zero: a miss.
        """
    def __len__(self) -> int: ...

class KdTree:
    """A k-d tree of its own over what a scene shows.

    For studies: it is built as the caller says, and counts what rays take in it. As long as it
    lives, the scene cannot change.
    """
    def __init__(
        self,
        scene: Scene,
        build: str = "lazy+scan+hierarchy",
        *,
        epsilon: float = 0.3,
        samples: SupportsIndex = 15,
        metric: str = "sah",
        origins: npt.ArrayLike | None = None,
    ) -> None:
        """scene: updated with structure "kdtree". build: "eager", or of lazy, scan and hierarchy
        those that are on, joined by +.

        epsilon, samples: of the scan; see `split_errors`. metric: sah, regions6, regions26, faces
        or exact; all but the first suppose rays that start in the box `origins` (2, 3).

        Raises ValueError for what is none of these, RuntimeError if the scene changed since its
        last update.
        """
    def closest_hit(
        self,
        origins: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        directions: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        t_near: float | npt.NDArray[np.float32] = 0.0,
        t_far: float | npt.NDArray[np.float32] = float("inf"),
    ) -> HitBatch:
        """As `Scene.closest_hit`, and the same bits."""
    def any_hit(
        self,
        origins: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        directions: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        t_near: float | npt.NDArray[np.float32] = 0.0,
        t_far: float | npt.NDArray[np.float32] = float("inf"),
    ) -> npt.NDArray[np.bool_]:
        """As `Scene.any_hit`."""
    def statistics(self) -> dict[str, float]:
        """What is built of the tree, and what all its rays have taken so far: a dict of

        `nodes`, `leaves`, `depth`, `references`, `bytes`, `sam_cost`, `quality` (smaller is better;
        NaN below two triangles), `built_fraction`, `nodes_visited`, `triangle_tests`.
        """
    def choose_metric(
        self, pilot: npt.NDArray[np.float32] | npt.NDArray[np.float64], camera: npt.ArrayLike
    ) -> tuple[str, npt.NDArray[np.float64]]:
        """The metric by which to split for rays that start where those of a sample start.

        pilot: (N, 3), origins of the sample's rays; of a ray to a light, the light. camera: where
        the eye is. Returns "sah", or "regions6" where most of them lie inside the scene, and the
        box (2, 3) in which nearly all do.
        """
    def split_errors(self, settings: Sequence[tuple[float, int]]) -> list[dict[str, float]]:
        """How far splits of scans are from the best, over the nodes of the exact tree.

        settings: of each scan epsilon, the error it may leave, and the number of planes of each
        of its two passes if that is infinite: one less than a power of two, at most 63. Returns
        for each a dict of `nodes_compared`, `worst_excess`, `mean_excess` (cost over the least
        possible cost, less 1), `worst_certificate`, `mean_certificate` (what the scan proves),
        `mean_samples` (planes tried). Nodes of so few entries that scans sort them do not count.
        """

class NodeBatch:
    """Nodes of the trees, one element a node."""
    @property
    def boxes(self) -> npt.NDArray[np.float64]:
        """(N, 2, 3) float64, world frame: lowest and highest corners."""
    @property
    def damage(self) -> npt.NDArray[np.float64]:
        """(N,) float64: tests lost since the node was last in order, as a share of all that it
        costs; 0 where the policy does not measure.
        """
    @property
    def rebuilt(self) -> npt.NDArray[np.bool_]:
        """(N,) bool: made anew by the last update that had something to do, or holding nodes that
        were.
        """
    def __len__(self) -> int: ...

class PointBatch:
    """Nearest points to N points, one element a point."""
    @property
    def distance(self) -> npt.NDArray[np.float64]:
        """(N,) float64, world units; inf: nothing within reach."""
    @property
    def point(self) -> npt.NDArray[np.float64]:
        """(N, 3) float64, world frame; zero: nothing."""
    @property
    def instance_id(self) -> npt.NDArray[np.uint32]:
        """(N,) uint32; 0xFFFFFFFF: nothing."""
    @property
    def prim_id(self) -> npt.NDArray[np.uint32]:
        """(N,) uint32, the triangle of the instance's mesh; 0xFFFFFFFF: nothing."""
    @property
    def u(self) -> npt.NDArray[np.float32]:
        """(N,) float32, weight of the triangle's second vertex."""
    @property
    def v(self) -> npt.NDArray[np.float32]:
        """(N,) float32, weight of the triangle's third vertex."""
    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """(N, 3) float32, geometric unit normal in the world frame, facing as the placed triangle
        is wound; zero: nothing.
        """
    def __len__(self) -> int: ...

class Scene:
    """A ray-tracing scene that stays alive between frames.

    Modify it, call `update`, then trace. Ids are whole numbers and never used twice. Wrong
    shapes, dtypes, indices and ids raise ValueError and change nothing; tracing a scene that
    changed since its last update raises RuntimeError.
    """
    def __init__(self, threads: SupportsIndex = 0, *, isa: str = "auto") -> None:
        """threads: how many to work with, this one included; 0: all cores.

        isa: auto, scalar, sse, avx2 or avx512; one that the machine lacks raises ValueError.
        """
    def add_mesh(
        self,
        vertices: npt.NDArray[np.float32],
        triangles: npt.NDArray[np.uint32],
        *,
        name: str = "",
        slots: npt.NDArray[np.uint16] | None = None,
        normal_ids: npt.NDArray[np.uint32] | None = None,
    ) -> int:
        """Adds a mesh and returns its id.

        vertices: (V, 3) float32, object space; triangles: (T, 3) uint32, vertex indices.
        slots: (T,) uint16, the material slot of each triangle; None: all 0.
        normal_ids: (T, 3) uint32; corners that share a number share a shading normal, 0xFFFFFFFF
        marks a flat corner, None: the whole mesh is flat, `triangles` itself: the whole mesh is
        smooth. Numbers lie below V, or below 3 T if that is more.

        Triangles with a vertex that is not finite, and those of zero area, cannot be hit;
        `update` counts them in its warnings. Raises ValueError for another shape or dtype or an
        index out of range.
        """
    def set_vertices(self, mesh_id: SupportsIndex, vertices: npt.NDArray[np.float32]) -> None:
        """Moves a mesh's vertices, keeping its triangles: the tree can be refitted.

        vertices: (V, 3) float32, object space, as many as the mesh has. Positions equal bit for
        bit to the present ones are no change. Raises ValueError for another count, shape or
        dtype.
        """
    def set_mesh(
        self,
        mesh_id: SupportsIndex,
        vertices: npt.NDArray[np.float32],
        triangles: npt.NDArray[np.uint32],
        *,
        slots: npt.NDArray[np.uint16] | None = None,
        normal_ids: npt.NDArray[np.uint32] | None = None,
    ) -> None:
        """Replaces the whole content of a mesh; its id, name and instances stay.

        Arguments as for `add_mesh`. Raises ValueError, and changes nothing, if one of them is
        wrong.
        """
    def remove_mesh(self, mesh_id: SupportsIndex) -> None:
        """Removes a mesh. Its id is never used again.

        Raises ValueError while instances use it.
        """
    def add_group(self, parent: SupportsIndex | None = None, *, name: str = "") -> int:
        """Adds a level of the scene's hierarchy (a collection, a parent) and returns its id.

        Groups carry no transform. Raises ValueError if the parent group does not exist.
        """
    def set_materials(
        self,
        base_color: npt.NDArray[np.float32],
        metallic: npt.NDArray[np.float32] | None = None,
        roughness: npt.NDArray[np.float32] | None = None,
        emission: npt.NDArray[np.float32] | None = None,
    ) -> None:
        """Replaces the scene's table of materials; a material's id is its row.

        base_color: (M, 4) float32, linear RGBA; metallic, roughness: (M,) float32, 0 and 0.5 if
        None; emission: (M, 3) float32, linear radiance, black if None.
        """
    def set_lights(self, lights: Sequence[Light]) -> None:
        """Replaces the scene's lights by a sequence of `regraft.Light`.

        With none at all the camera carries a headlight.
        """
    def set_world(self, color: npt.ArrayLike) -> None:
        """Sets the background radiance, three numbers, linear RGB.

        It is also the ambient light of `direct` shading.
        """
    def counts(self) -> dict[str, int]:
        """Numbers of `meshes`, `instances`, `groups` and `triangles` (of meshes) that exist."""
    def add_instance(
        self,
        mesh_id: SupportsIndex,
        transform: npt.NDArray[np.float64] | None = None,
        *,
        group: SupportsIndex | None = None,
        name: str = "",
        materials: npt.NDArray[np.uint32] | Sequence[SupportsIndex] | None = None,
        object_index: SupportsIndex = 0,
    ) -> int:
        """Places a mesh in the world and returns the instance's id.

        transform: (4, 4) float64, object to world, column vectors, last row 0 0 0 1; None:
        identity. One that is not finite is taken, but cannot be hit.
        materials: material ids, one a slot of the mesh; slots without one have the standard
        material.
        object_index: what the pass of that name shows.

        Raises ValueError if the mesh or the group does not exist.
        """
    def add_instances(
        self,
        mesh_ids: npt.NDArray[np.uint32],
        transforms: npt.NDArray[np.float64],
        *,
        groups: npt.NDArray[np.uint32] | None = None,
        materials: Sequence[int] | Sequence[Sequence[int]] | None = None,
        object_indices: npt.NDArray[np.uint32] | None = None,
    ) -> npt.NDArray[np.uint32]:
        """Places N meshes in the world and returns the instances' ids, (N,) uint32.

        mesh_ids: (N,) uint32; transforms: (N, 4, 4) float64, object to world; groups: (N,)
        uint32, 0xFFFFFFFF for none; materials: one tuple of ids for all, or a list of N;
        object_indices: (N,) uint32. Raises ValueError, and adds none, if one of them is wrong.
        """
    def set_transform(self, instance_id: SupportsIndex, m: npt.NDArray[np.float64]) -> None:
        """Moves an instance; m: (4, 4) float64, object to world, column vectors.

        A matrix equal bit for bit to the present one is no change.
        """
    def set_transforms(
        self,
        ids: npt.NDArray[np.uint32] | Sequence[SupportsIndex],
        transforms: npt.NDArray[np.float64],
    ) -> None:
        """Moves N instances: ids (N,) uint32, transforms (N, 4, 4) float64, object to world.

        Raises ValueError, and moves none, if one of them is wrong.
        """
    def set_visible(self, instance_id: SupportsIndex, flag: bool) -> None:
        """Hides or shows an instance. A hidden one keeps its mesh's tree."""
    def set_instance_materials(
        self, instance_id: SupportsIndex, ids: npt.NDArray[np.uint32] | Sequence[SupportsIndex]
    ) -> None:
        """Gives an instance other materials, one id a slot of its mesh."""
    def remove_instance(self, instance_id: SupportsIndex) -> None:
        """Removes an instance. Its id is never used again."""
    def remove_instances(self, ids: npt.NDArray[np.uint32] | Sequence[SupportsIndex]) -> None:
        """Removes instances: ids (N,) uint32.

        Raises ValueError, and removes none, if an id is wrong or given twice.
        """
    def update(
        self,
        policy: str = "auto",
        structure: str = "auto",
        layout: str = "two-level",
        *,
        frames_left: SupportsIndex | None = None,
        camera: Camera | None = None,
    ) -> UpdateStatistics:
        """Brings the trees up to date with the scene; free where nothing changed.

        policy: auto, refit, rebuild, lm, rtdeform, selective, selective+rotate or shot; the last
        plans for the key frames that `set_key_vertices` and `set_key_transforms` gave.
        structure: auto, bvh or kdtree; layout: two-level or flat.
        frames_left: how many frames the shot still has, if that is known. camera: from where the
        scene is going to be looked at, if that is known. Both help `auto`. Releases the GIL.

        Raises ValueError for an unknown name, or for "shot" if something moves whose key frames
        nobody gave.
        """
    def quality(self, fresh: bool = False) -> dict[str, float]:
        """How good the trees are: a dict of

        `sah_cost` and `culling_efficiency`, expected tests of a ray that hits the scene; `epo`,
        the extra tests that overlap of nodes causes on surfaces; `origin_cost`, expected tests of
        a ray that starts anywhere in the scene's box (0 of a k-d tree); `cost_ratio`, the cost
        now over that of the last build, or of a full build made beside it if `fresh`; `depth`;
        `bytes`; of a k-d tree also `kdtree_q`, lower is better, comparable between scenes of any
        size (Hunt, Mark, Fussell 2007), not a number for a single triangle.

        Raises RuntimeError if the scene changed since its last update.
        """
    def bounds(self) -> npt.NDArray[np.float64]:
        """World box of what can be hit: (2, 3) float64, lowest and highest corner.

        Raises ValueError if there is nothing, RuntimeError if the scene changed since its last
        update.
        """
    def closest_hit(
        self,
        origins: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        directions: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        t_near: float | npt.NDArray[np.float32] = 0.0,
        t_far: float | npt.NDArray[np.float32] = float("inf"),
    ) -> HitBatch:
        """Nearest hit of each of N rays in [t_near, t_far].

        origins, directions: (N, 3) float32 or float64, world frame; directions need not be unit
        vectors.
        t_near, t_far: a number or (N,) float32, in units of the direction's length. Rays that are
        not finite, or whose direction is zero, miss. Among equally near hits the lowest
        (instance_id, prim_id) counts. Large batches are traced in an order of their own, so theirs
        does not matter. Releases the GIL.

        Raises ValueError for another shape or dtype, RuntimeError if the scene changed since its
        last update.
        """
    def closest_hit_brute_force(
        self,
        origins: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        directions: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        t_near: float | npt.NDArray[np.float32] = 0.0,
        t_far: float | npt.NDArray[np.float32] = float("inf"),
    ) -> HitBatch:
        """`closest_hit` without any tree: every ray against every triangle.

        For checks: whatever the policy, structure and layout, `closest_hit` returns these very
        bits. Takes about a nanosecond a ray and triangle.
        """
    def any_hit(
        self,
        origins: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        directions: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        t_near: float | npt.NDArray[np.float32] = 0.0,
        t_far: float | npt.NDArray[np.float32] = float("inf"),
    ) -> npt.NDArray[np.bool_]:
        """Whether each of N rays hits anything in [t_near, t_far]: (N,) bool.

        Arguments and errors as for `closest_hit`.
        """
    def closest_point(
        self,
        points: npt.NDArray[np.float32] | npt.NDArray[np.float64],
        max_distance: float = float("inf"),
    ) -> PointBatch:
        """Nearest point of the scene's surfaces to each of N points.

        points: (N, 3) float32 or float64, world frame. max_distance: how far to look, world units.
        Points that are not finite find nothing. Among equally near triangles the lowest
        (instance_id, prim_id) counts. Distances are computed in double. Releases the GIL.

        Raises ValueError for another shape or dtype or a negative distance, RuntimeError if the
        scene changed since its last update.
        """
    def set_key_vertices(self, mesh_id: SupportsIndex, frames: npt.NDArray[np.float32]) -> None:
        """Tells where a mesh's vertices will be in key frames of the shot, for policy="shot".

        frames: (K, V, 3) float32, object space; eight key frames at most are looked at. No
        change of the scene: trees read them when they are built, so give them before the first
        update. `set_mesh` forgets them. Raises ValueError for another shape or dtype.
        """
    def set_key_transforms(
        self, instance_id: SupportsIndex, frames: npt.NDArray[np.float64]
    ) -> None:
        """Tells where an instance will be in key frames of the shot, for policy="shot".

        frames: (K, 4, 4) float64. As `set_key_vertices`.
        """
    def damaged_nodes(self, depth: SupportsIndex) -> NodeBatch:
        """The nodes `depth` levels below the root, with leaves that end above, and their damage.

        Levels are counted through the top tree into those of the meshes, once an instance.

        Raises RuntimeError if the scene changed since its last update.
        """
    def rebuilt_nodes(self) -> NodeBatch:
        """The highest nodes that the last update which had something to do made anew.

        Raises RuntimeError if the scene changed since its last update.
        """
    def render(
        self,
        camera: Camera,
        width: SupportsIndex,
        height: SupportsIndex,
        *,
        shading: str = "direct",
        samples: SupportsIndex = 1,
        passes: Sequence[str] = ("combined",),
        region: tuple[int, int, int, int] | None = None,
        seed: SupportsIndex = 0,
        transparent: bool = False,
        progress: Callable[[float], Any] | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> Frame:
        """Renders a picture of width by height pixels through a `regraft.Camera`.

        shading: clay, occlusion, direct, reflection or cost. samples: rays a pixel; with one it
        goes through the pixel's centre. passes: any of combined (premultiplied linear RGBA),
        depth (distance from the eye, inf where nothing is), normal (world frame), object_index,
        cost (nodes and triangles tested). region: pixels (x0, y0, x1, y1) from the lower left
        corner, half open; the passes then have its size. seed: of the samples; equal calls give
        equal pictures, whatever the number of threads.
        transparent: alpha 0 where nothing is, instead of the world's colour.

        progress(fraction) and cancel() -> bool are called on this thread about every 20 ms; after
        cancel returned true the frame comes back with `cancelled` set. What they raise, and
        Ctrl-C, ends the render. Releases the GIL.

        Raises ValueError for a wrong argument, RuntimeError if the scene changed since its last
        update.
        """

class UpdateStatistics:
    """What an update did and what the trees are like after it."""

    update_ms: float
    policy: str
    structure: str
    layout: str
    triangles: int
    instances: int
    moved_instances: int
    deformed_meshes: int
    deformed_triangles: int
    nodes: int
    nodes_refitted: int
    nodes_rebuilt: int
    pairs_considered: int
    pairs_restructured: int
    late_updates: int
    late_update_ms: float
    culling_efficiency: float
    cost_ratio: float
    kdtree_nodes: int
    kdtree_built_fraction: float
    kdtree_unbuilt_nodes: int
    kdtree_large_leaves: int
    memory_bytes: int
    left_out: list[str]
    warnings: list[str]
    def as_dict(self) -> dict[str, Any]:
        """All of it as a dict of plain Python values, in the order of the statistics line."""
    def __repr__(self) -> str: ...
    @property
    def predicted_benefits(self) -> npt.NDArray[np.float64]:
        """of each pair tried: expected tests a frame that were to be saved, float64"""
    @property
    def realised_savings(self) -> npt.NDArray[np.float64]:
        """of each pair tried: expected tests a frame that were saved, float64"""
    @property
    def select_ms(self) -> float:
        """choosing pairs and restructuring them, milliseconds"""

def available_isas() -> list[str]:
    """Instruction sets that this machine has kernels for, weakest first."""

def best_isa() -> str:
    """The strongest of `available_isas`, which isa="auto" takes."""

def calibrate(threads: SupportsIndex = 0) -> dict[str, float]:
    """Measures the machine costs, and changes nothing. Takes a few seconds; releases the
    GIL.
    """

def hardware_threads() -> int:
    """Cores that threads=0 takes."""

def machine_costs() -> dict[str, float]:
    """What updates take operations for, in units of one expected test of a ray: `leaf`, a
    triangle test; `rebuild`, a build of m triangles divided by m log2 m; `refine`, looking at one
    pair of nodes; `morton`, a quick build divided by m.
    """

def set_machine_costs(
    *, leaf: object = None, rebuild: object = None, refine: object = None, morton: object = None
) -> dict[str, float]:
    """Changes what None does not leave as it is, for all scenes of the process; returns all.

    Raises ValueError for a cost that is not a number above 0 and below 1e9.
    """
