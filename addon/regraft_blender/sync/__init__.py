"""Reads a Blender scene and notes what changed since it was last read."""
