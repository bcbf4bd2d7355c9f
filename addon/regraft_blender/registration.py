"""Puts the add-on's classes, properties and handlers into Blender, and takes them out."""

from __future__ import annotations

import atexit
import logging

import bpy

from . import compat, engine, handlers, session
from .ui import operators, overlay, panels, properties, study

log = logging.getLogger(__name__)

CLASSES = (
    *properties.CLASSES,
    *operators.CLASSES,
    engine.RegraftEngine,
    *panels.SIDEBAR,
    *study.CLASSES,
    *panels.PROPERTIES,
)


def register() -> None:
    """Add what is not there yet."""
    for cls in CLASSES:
        if not getattr(cls, "is_registered", False):
            bpy.utils.register_class(cls)
    properties.attach()
    panels.attach()
    overlay.attach()
    handlers.register()
    # As a Python module, bpy 4.5 hangs at exit while a handler or class is still registered.
    if getattr(bpy.app, "module", False):
        atexit.register(unregister)
    compat.forget()
    if compat.problem():
        log.warning("Regraft is registered, but cannot render: %s", compat.problem())


def unregister() -> None:
    """Remove what is there, sessions first: viewports may just be tracing them."""
    atexit.unregister(unregister)
    session.close_all()
    handlers.unregister()
    overlay.detach()
    study.detach()
    panels.detach()
    properties.detach()
    for cls in reversed(CLASSES):
        if getattr(cls, "is_registered", False):
            bpy.utils.unregister_class(cls)
