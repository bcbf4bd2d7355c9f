"""Collections and parents as groups: the levels a lazily built tree can open one by one."""

from __future__ import annotations

import bpy

from .delta import NONE, GroupData


class Hierarchy:
    """Hands out a group for every collection and every object that others hang on.

    A group is a hint for the tree and carries no transform, so an object that is parented anew
    later keeps the group it was first given.
    """

    def __init__(self) -> None:
        self._groups: dict[int, int] = {}
        self._new: list[GroupData] = []
        self._homes: dict[int, bpy.types.Collection] = {}
        self._above: dict[int, bpy.types.Collection] = {}

    def open(self, scene: bpy.types.Scene) -> None:
        """Look the collections up; needed before `group_of`, for the time of one reading."""
        self._homes.clear()
        self._above.clear()
        pending = [scene.collection]
        while pending:
            collection = pending.pop()
            for ob in collection.objects:
                self._homes.setdefault(ob.original.as_pointer(), collection)
            for child in collection.children:
                if self._above.setdefault(child.as_pointer(), collection) is collection:
                    pending.append(child)

    def close(self) -> None:
        """Let go of Blender's data."""
        self._homes.clear()
        self._above.clear()

    def take_new(self) -> list[GroupData]:
        """The groups made since this was last called, parents first."""
        new, self._new = self._new, []
        return new

    def group_of(self, ob: bpy.types.Object) -> int:
        """Group that the original object `ob` lies in, or NONE."""
        if ob.parent is not None:
            return self.group_under(ob.parent)
        return self._home_group(ob)

    def group_under(self, ob: bpy.types.Object) -> int:
        """Group of what hangs on the original object `ob`: its children, or its instances."""
        chain = [ob]
        while chain[-1].as_pointer() not in self._groups and chain[-1].parent is not None:
            chain.append(chain[-1].parent)
        group = self._groups.get(chain[-1].as_pointer(), NONE)
        if group == NONE:
            group = self._add(chain[-1].as_pointer(), self._home_group(chain[-1]), chain[-1].name)
        for below in reversed(chain[:-1]):
            group = self._add(below.as_pointer(), group, below.name)
        return group

    def _home_group(self, ob: bpy.types.Object) -> int:
        home = self._homes.get(ob.as_pointer())
        return NONE if home is None else self._collection_group(home)

    def _collection_group(self, collection: bpy.types.Collection) -> int:
        known = self._groups.get(collection.as_pointer())
        if known is not None:
            return known
        above = self._above.get(collection.as_pointer())
        parent = NONE if above is None else self._collection_group(above)
        return self._add(collection.as_pointer(), parent, collection.name)

    def _add(self, address: int, parent: int, name: str) -> int:
        handle = self._groups[address] = len(self._groups)
        self._new.append(GroupData(handle, None if parent == NONE else parent, name))
        return handle
