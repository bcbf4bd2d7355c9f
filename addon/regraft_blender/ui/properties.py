"""Settings: Scene.regraft and ViewLayer.regraft. Names and values are those of the NumPy API."""

# mypy: disable-error-code="valid-type"
# Blender's properties are calls where Python expects types.

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, PointerProperty

SHADINGS = (
    ("clay", "Clay", "Grey surfaces under a headlight, no shadows: the fastest"),
    ("occlusion", "Occlusion", "Grey surfaces, darker where they are hemmed in"),
    ("direct", "Direct", "The scene's lights with true shadows"),
    ("reflection", "Reflection", "Direct light and one bounce off smooth surfaces"),
    ("cost", "Cost", "What each pixel's rays cost, as a heat map"),
)
POLICIES = (
    ("auto", "Auto", "Let Regraft choose for each frame"),
    ("refit", "Refit", "Keep the trees and only fit their boxes to what moved"),
    ("rebuild", "Rebuild", "Build the trees of what moved anew in every frame"),
    ("selective", "Selective", "Measure the damage and mend only what is worth it"),
    ("selective+rotate", "Selective + Rotate", "The same, with rotations of damaged nodes first"),
    ("lm", "LM", "Rebuild subtrees whose volume has shrunk against that of their parts"),
    ("rtdeform", "RT-DEFORM", "Rebuild all when the areas of nodes have drifted by 40 percent"),
)
STRUCTURES = (
    ("auto", "Auto", "Let Regraft choose"),
    ("bvh", "BVH", "A bounding volume hierarchy"),
    ("kdtree", "K-d Tree", "Space cut by planes only where rays go: huge scenes, little seen"),
)
LAYOUTS = (
    ("two-level", "Two Levels", "A tree for each mesh and one over all instances"),
    ("flat", "Flat", "One tree over all triangles of the scene"),
)


def _redraw(_settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class RegraftSceneSettings(bpy.types.PropertyGroup):
    """How a scene is previewed."""

    shading: EnumProperty(
        name="Shading", description="What surfaces look like", items=SHADINGS, default="direct"
    )
    samples: IntProperty(
        name="Samples",
        description="Rays through each pixel of a final frame; more than one gives smooth edges "
        "and soft shadows",
        default=1,
        min=1,
        max=4096,
        soft_max=64,
    )
    viewport_samples: IntProperty(
        name="Viewport",
        description="Samples of a viewport: rays through each pixel, traced one after another",
        default=16,
        min=1,
        max=4096,
        soft_max=64,
    )
    policy: EnumProperty(
        name="Policy",
        description="How the trees follow the animation",
        items=POLICIES,
        default="auto",
    )
    structure: EnumProperty(
        name="Structure", description="Which kind of tree", items=STRUCTURES, default="auto"
    )
    layout: EnumProperty(
        name="Layout", description="How trees are put together", items=LAYOUTS, default="two-level"
    )
    threads: IntProperty(
        name="Threads",
        description="How many cores to use; 0: as many as Blender's own settings say",
        default=0,
        min=0,
        max=1024,
    )
    show_nodes: BoolProperty(
        name="Nodes",
        description="Draw boxes of the trees' nodes over the viewports: blue where they are in "
        "order, red where half of what they cost is lost, yellow where they were made anew in this "
        "frame",
        default=False,
        update=_redraw,
    )
    node_depth: IntProperty(
        name="Depth",
        description="How many levels below the root the drawn nodes are",
        default=6,
        min=0,
        max=60,
        soft_max=16,
        update=_redraw,
    )
    use_headlight: BoolProperty(
        name="Headlight",
        description="Light the scene from the camera and leave its own lights out. A scene "
        "without lights always has a headlight",
        default=False,
    )


class RegraftLayerSettings(bpy.types.PropertyGroup):
    """Passes that only Regraft has."""

    use_pass_cost: BoolProperty(
        name="Cost",
        description="Deliver the number of nodes and triangles each pixel's rays were tested with",
        default=False,
    )


CLASSES = (RegraftSceneSettings, RegraftLayerSettings)


def attach() -> None:
    """Give scenes and view layers their settings."""
    bpy.types.Scene.regraft = PointerProperty(type=RegraftSceneSettings, name="Regraft")
    bpy.types.ViewLayer.regraft = PointerProperty(type=RegraftLayerSettings, name="Regraft")


def detach() -> None:
    """Take the settings away; values stay in the file."""
    for owner in (bpy.types.Scene, bpy.types.ViewLayer):
        if hasattr(owner, "regraft"):
            del owner.regraft
