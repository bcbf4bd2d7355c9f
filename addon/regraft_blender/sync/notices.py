"""What the user should know about a scene, said once."""

from __future__ import annotations

import bpy

NOT_DRAWN = {
    "VOLUME": "volumes",
    "CURVES": "hair curves",
    "POINTCLOUD": "point clouds",
    "GPENCIL": "grease pencil objects",
    "GREASEPENCIL": "grease pencil objects",
}


class Notices:
    """Warnings and remarks that have not been handed out yet; each is handed out only once."""

    def __init__(self) -> None:
        self._said: set[str] = set()
        self._warnings: list[str] = []
        self._remarks: list[str] = []

    def warn(self, text: str, once_for: str = "") -> None:
        """Note a warning, unless one was noted before for the same reason."""
        self._note(self._warnings, text, once_for)

    def remark(self, text: str, once_for: str = "") -> None:
        """Note something that was left out on purpose."""
        self._note(self._remarks, text, once_for)

    def take(self) -> tuple[list[str], list[str]]:
        """New warnings and new remarks."""
        taken = self._warnings, self._remarks
        self._warnings, self._remarks = [], []
        return taken

    def look_at(self, ob: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> None:
        """Note what of an evaluated object cannot be drawn as Blender would."""
        kind = NOT_DRAWN.get(ob.type)
        if kind:
            self.warn(f"'{ob.name}': {kind} are not drawn", once_for=kind)
        if any(_is_hair(system.settings) for system in ob.particle_systems):
            self.warn(f"'{ob.name}': hair particles are not drawn", once_for="hair")
        if ob.original.holdout_get(view_layer=view_layer):
            self.warn(f"'{ob.name}': holdouts are drawn as ordinary objects", once_for="holdout")
        if ob.original.indirect_only_get(view_layer=view_layer):
            self.remark(f"'{ob.name}' and other indirect-only objects: not drawn", "indirect")

    def _note(self, notes: list[str], text: str, once_for: str) -> None:
        reason = once_for or text
        if reason not in self._said:
            self._said.add(reason)
            notes.append(text)


def _is_hair(settings: bpy.types.ParticleSettings) -> bool:
    return settings.type == "HAIR" and settings.render_type == "PATH"
