"""The instances a scene had when it was last read, and how a new list differs from it.

Pure NumPy. An instance is known by a 64-bit key that the reader makes from what Blender calls it,
and by the handle it keeps until it is removed. Matrices are Blender's: (N,16) float32, column by
column, object to world.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from .delta import Handles, InstanceBatch, SceneDelta, no_handles

Keys = npt.NDArray[np.uint64]
Matrices = npt.NDArray[np.float32]
Places = npt.NDArray[np.int64]
Exists = Callable[[Keys], npt.NDArray[np.bool_]]

# Hidden instances are kept so that they come back for free; beyond this many only as long as
# they are not the majority.
ALWAYS_KEPT_HIDDEN = 1_000


@dataclass(frozen=True, eq=False)
class Rows:
    """N instances with geometry. `positions` (N,) tells where each stands in Blender's list,
    `materials` (N,) indexes a list of material tuples, `owners` (N,) addresses the object that
    brings the instance in; `groups` and the rest as in InstanceBatch."""

    keys: Keys
    positions: Places
    meshes: Handles
    matrices: Matrices
    materials: Places
    groups: Handles
    object_indices: Handles
    owners: Keys

    def __len__(self) -> int:
        return len(self.keys)

    def take(self, which: Places | npt.NDArray[np.bool_]) -> Rows:
        """The rows at `which`."""
        return Rows(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    @staticmethod
    def concatenated(parts: Sequence[Rows]) -> Rows:
        """One after the other."""
        names = Rows.__dataclass_fields__
        return Rows(*(np.concatenate([getattr(part, n) for part in parts]) for n in names))

    @staticmethod
    def none() -> Rows:
        """No rows."""
        handles = no_handles()
        keys, numbers = np.empty(0, np.uint64), np.empty(0, np.int64)
        matrices = np.empty((0, 16), np.float32)
        return Rows(keys, numbers, handles, matrices, numbers, handles, handles, keys)


def as_transforms(matrices: Matrices) -> npt.NDArray[np.float64]:
    """(N,16) column by column → (N,4,4) float64."""
    return np.ascontiguousarray(matrices.reshape(-1, 4, 4).transpose(0, 2, 1), np.float64)


def mixed(seeds: Keys, words: npt.NDArray[np.int32]) -> Keys:
    """(N,) 64-bit hashes of seeds (N,) and words (N,W): FNV-1a over the words. Seeds are scrambled
    first, or a seed and a word that differ alike would cancel out."""
    keys = _scrambled(seeds)
    for column in words.T:
        keys = (keys ^ column.astype(np.uint32)) * np.uint64(0x100000001B3)
        keys ^= keys >> np.uint64(29)
    return _scrambled(keys)


def _scrambled(keys: Keys) -> Keys:
    """Any bit changes about half of them: the finisher of SplitMix64 (Steele, Lea, Flood, Fast
    splittable pseudorandom number generators, OOPSLA 2014, Fig. 16)."""
    keys = (keys ^ (keys >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    keys = (keys ^ (keys >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return keys ^ (keys >> np.uint64(31))


def made_unique(keys: Keys) -> Keys:
    """Equal keys told apart by how often they came before."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    repeats = np.flatnonzero(ordered[1:] == ordered[:-1]) + 1
    if not len(repeats):
        return keys
    starts = np.maximum.accumulate(
        np.where(np.diff(ordered, prepend=~ordered[:1]) != 0, np.arange(len(keys)), 0)
    )
    ranks = (np.arange(len(keys)) - starts).astype(np.int32)
    unique = keys.copy()
    later = order[repeats]
    unique[later] = mixed(keys[later], ranks[repeats][:, None])
    return unique


@dataclass(frozen=True, eq=False)
class Matching:
    """Old rows (the first `shown_count` in the list, then hidden ones) against new rows.

    Rows `old_at` and `new_at` are the same instances, pair by pair; `replaced` are old rows whose
    instance must be made anew because it took another mesh or pass index.
    """

    old: Rows
    old_handles: Handles
    shown_count: int
    new: Rows
    old_at: Places
    new_at: Places
    replaced: Places

    @staticmethod
    def of(shown: Rows, hidden: Rows, old_handles: Handles, new: Rows) -> Matching:
        """Match rows by key."""
        old = Rows.concatenated([shown, hidden])
        _, old_at, new_at = np.intersect1d(
            old.keys, new.keys, assume_unique=True, return_indices=True
        )
        same = old.meshes[old_at] == new.meshes[new_at]
        same &= old.object_indices[old_at] == new.object_indices[new_at]
        pairs = old_at[same], new_at[same]
        return Matching(old, old_handles, len(shown), new, *pairs, old_at[~same])

    def is_new(self) -> npt.NDArray[np.bool_]:
        """(N,) True for the new rows without an old one."""
        is_new = np.ones(len(self.new), np.bool_)
        is_new[self.new_at] = False
        return is_new

    def gone(self) -> Places:
        """Old rows that are no longer in the list."""
        is_gone = np.ones(len(self.old), np.bool_)
        is_gone[self.old_at] = is_gone[self.replaced] = False
        return np.flatnonzero(is_gone)


class InstanceTable:
    """Instances by key: those in Blender's list now, and hidden ones that may come back."""

    def __init__(self) -> None:
        self.rows = Rows.none()
        self.handles = no_handles()
        self._hidden = Rows.none()
        self._hidden_handles = no_handles()
        self._next_handle = 0

    def used_meshes(self) -> set[int]:
        """Handles of the meshes that some instance, shown or hidden, uses."""
        return set(self.rows.meshes.tolist()) | set(self._hidden.meshes.tolist())

    def move(self, matrices: Matrices, delta: SceneDelta) -> None:
        """Same instances, new `matrices` of Blender's whole list."""
        now = matrices[self.rows.positions]
        has_moved = (now != self.rows.matrices).any(axis=1)
        if has_moved.any():
            delta.moved = self.handles[has_moved]
            delta.transforms = as_transforms(now[has_moved])
            self.rows = replace(self.rows, matrices=now)

    def update(
        self, rows: Rows, sets: Sequence[tuple[int, ...]], exists: Exists, delta: SceneDelta
    ) -> None:
        """Another list of instances: note in `delta` which came, went, moved, were hidden or
        shown or took other materials.

        `sets` are the material tuples that `rows.materials` indexes. `exists(owners)` tells which
        owners are still in the file: their instances that are gone from the list are hidden,
        others removed.
        """
        known = np.concatenate([self.handles, self._hidden_handles])
        match = Matching.of(self.rows, self._hidden, known, rows)
        self.rows, self.handles = rows, self._handles_for(match)
        _note_changes(match, self.handles, sets, delta)
        is_new = match.is_new()
        if is_new.any():
            delta.added = _batch(rows.take(is_new), self.handles[is_new], sets)
        self._retire(match, exists, delta)

    def _handles_for(self, match: Matching) -> Handles:
        """(N,) old handles for the rows that were known, new ones for the others."""
        is_new = match.is_new()
        handles = np.empty(len(is_new), np.uint32)
        handles[match.new_at] = match.old_handles[match.old_at]
        end = self._next_handle + int(is_new.sum())
        handles[is_new] = np.arange(self._next_handle, end, dtype=np.uint32)
        self._next_handle = end
        return handles

    def _retire(self, match: Matching, exists: Exists, delta: SceneDelta) -> None:
        """Hide or remove what is no longer in the list."""
        gone = match.gone()
        keeps = exists(match.old.owners[gone])
        if keeps.sum() > max(ALWAYS_KEPT_HIDDEN, len(match.new)):
            keeps[:] = False
        kept, removed = gone[keeps], np.concatenate([gone[~keeps], match.replaced])
        delta.hidden = match.old_handles[kept[kept < match.shown_count]]
        delta.removed = match.old_handles[removed]
        self._hidden, self._hidden_handles = match.old.take(kept), match.old_handles[kept]


def _note_changes(
    match: Matching, handles: Handles, sets: Sequence[tuple[int, ...]], delta: SceneDelta
) -> None:
    """What happened to the instances that are in both lists."""
    old, new, old_at, new_at = match.old, match.new, match.old_at, match.new_at
    moved_at = new_at[(old.matrices[old_at] != new.matrices[new_at]).any(axis=1)]
    delta.moved = handles[moved_at]
    delta.transforms = as_transforms(new.matrices[moved_at])
    delta.shown = match.old_handles[old_at[old_at >= match.shown_count]]
    changed = new_at[old.materials[old_at] != new.materials[new_at]]
    delta.rematerialised = {
        handle: sets[index]
        for handle, index in zip(
            handles[changed].tolist(), new.materials[changed].tolist(), strict=True
        )
    }


def _batch(rows: Rows, handles: Handles, sets: Sequence[tuple[int, ...]]) -> InstanceBatch:
    return InstanceBatch(
        handles=handles,
        meshes=rows.meshes,
        transforms=as_transforms(rows.matrices),
        groups=rows.groups,
        materials=[sets[index] for index in rows.materials.tolist()],
        object_indices=rows.object_indices,
    )
