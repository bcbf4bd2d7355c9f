"""The table of instances: what it notes when Blender's list changes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from regraft_blender.sync.delta import SceneDelta
from regraft_blender.sync.instance_table import (
    ALWAYS_KEPT_HIDDEN,
    InstanceTable,
    Rows,
    as_transforms,
    made_unique,
    mixed,
)

SETS = [(0,), (1,), (2, 3)]


def rows(*keys: int, x: float = 0.0, mesh: int = 0, materials: int = 0, index: int = 0) -> Rows:
    """Instances with these keys, all alike."""
    count = len(keys)
    matrices = np.tile(np.eye(4, dtype=np.float32).ravel(), (count, 1))
    matrices[:, 12] = x
    return Rows(
        keys=np.array(keys, np.uint64),
        positions=np.arange(count),
        meshes=np.full(count, mesh, np.uint32),
        matrices=matrices,
        materials=np.full(count, materials, np.int64),
        groups=np.zeros(count, np.uint32),
        object_indices=np.full(count, index, np.uint32),
        owners=np.array(keys, np.uint64),
    )


def all_exist(owners: Any) -> Any:
    return np.ones(len(owners), np.bool_)


def none_exists(owners: Any) -> Any:
    return np.zeros(len(owners), np.bool_)


def updated(table: InstanceTable, new: Rows, exists: Any = all_exist) -> SceneDelta:
    delta = SceneDelta()
    table.update(new, SETS, exists, delta)
    return delta


def test_new_rows_are_added_once() -> None:
    table = InstanceTable()
    delta = updated(table, rows(5, 6, 7))
    assert delta.added is not None
    assert delta.added.handles.tolist() == [0, 1, 2]
    assert updated(table, rows(5, 6, 7)).is_empty()


def test_handles_follow_their_keys_into_another_order() -> None:
    table = InstanceTable()
    updated(table, rows(5, 6, 7))
    assert updated(table, rows(7, 5, 6)).is_empty()
    assert table.handles.tolist() == [2, 0, 1]


def test_what_is_gone_but_exists_is_hidden_and_comes_back_for_free() -> None:
    table = InstanceTable()
    updated(table, rows(5, 6))
    delta = updated(table, rows(5))
    assert delta.hidden.tolist() == [1]
    assert not len(delta.removed)
    assert table.used_meshes() == {0}
    delta = updated(table, rows(5, 6, x=2.0))
    assert delta.shown.tolist() == [1]
    assert delta.moved.tolist() == [0, 1]
    assert delta.added is None


def test_what_no_longer_exists_is_removed_hidden_or_not() -> None:
    table = InstanceTable()
    updated(table, rows(5, 6))
    updated(table, rows(5))
    delta = updated(table, rows(), none_exists)
    assert sorted(delta.removed.tolist()) == [0, 1]
    assert table.used_meshes() == set()


def test_another_mesh_or_pass_index_makes_the_instance_anew() -> None:
    for change in ({"mesh": 3}, {"index": 3}):
        table = InstanceTable()
        updated(table, rows(5))
        delta = updated(table, rows(5, **change))  # type: ignore[arg-type]
        assert delta.removed.tolist() == [0]
        assert delta.added is not None
        assert delta.added.handles.tolist() == [1]


def test_other_materials_are_noted_by_instance() -> None:
    table = InstanceTable()
    updated(table, rows(5, 6))
    assert updated(table, rows(5, 6, materials=2)).rematerialised == {0: (2, 3), 1: (2, 3)}


def test_only_what_moved_is_moved() -> None:
    table = InstanceTable()
    updated(table, rows(5, 6))
    matrices = table.rows.matrices.copy()
    matrices[1, 13] = 4.0
    delta = SceneDelta()
    table.move(matrices, delta)
    assert delta.moved.tolist() == [1]
    assert delta.transforms[0, :3, 3].tolist() == [0.0, 4.0, 0.0]
    again = SceneDelta()
    table.move(matrices, again)
    assert again.is_empty()


def test_matrices_are_found_by_position_in_blenders_list() -> None:
    table = InstanceTable()
    updated(table, replace(rows(5), positions=np.array([2])))
    listed = np.zeros((3, 16), np.float32)
    listed[2, 12] = 9.0
    delta = SceneDelta()
    table.move(listed, delta)
    assert delta.transforms[0, 0, 3] == 9.0


def test_hidden_instances_do_not_pile_up() -> None:
    table = InstanceTable()
    for start in range(0, 20 * ALWAYS_KEPT_HIDDEN, ALWAYS_KEPT_HIDDEN):
        updated(table, rows(*range(start, start + ALWAYS_KEPT_HIDDEN)))
        assert len(table._hidden) <= 2 * ALWAYS_KEPT_HIDDEN


def test_column_order_becomes_row_order() -> None:
    matrix = np.arange(16, dtype=np.float32)
    assert as_transforms(matrix[None])[0].tolist() == matrix.reshape(4, 4).T.tolist()


@given(st.lists(st.integers(0, 3), max_size=40))
def test_unique_keys_are_unique_and_the_first_of_each_kind_is_kept(keys: list[int]) -> None:
    array = np.array(keys, np.uint64)
    unique = made_unique(array)
    assert len(set(unique.tolist())) == len(keys)
    _, first = np.unique(array, return_index=True)
    assert (unique[first] == array[first]).all()


def test_neighbouring_words_give_different_keys() -> None:
    words = np.stack(np.meshgrid(*[np.arange(40)] * 3), -1).reshape(-1, 3).astype(np.int32)
    keys = mixed(np.zeros(len(words), np.uint64), words)
    assert len(np.unique(keys)) == len(words)


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 2)), max_size=12), st.data())
def test_the_mirror_of_any_history_equals_the_last_list(
    first: list[tuple[int, int]], data: st.DataObject
) -> None:
    table = InstanceTable()
    shown: dict[int, bool] = {}
    lists = [first, *data.draw(st.lists(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 2)))))]
    for entries in lists:
        chosen = dict(entries)
        new = rows(*chosen)
        new = replace(new, meshes=np.array(list(chosen.values()), np.uint32))
        delta = updated(table, new)
        if delta.added is not None:
            shown |= dict.fromkeys(delta.added.handles.tolist(), True)
        for handle in delta.removed.tolist():
            del shown[handle]
        shown |= dict.fromkeys(delta.hidden.tolist(), False)
        shown |= dict.fromkeys(delta.shown.tolist(), True)
        assert {h for h, is_shown in shown.items() if is_shown} == set(table.handles.tolist())
