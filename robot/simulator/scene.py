"""The world of a world file, in metres: what the camera sees and what is in the robot's way."""

from dataclasses import replace

import numpy as np

from facetlog.robot.rendering.solids import cuboid, cylinder, placed, prism, pyramid, wedge
from facetlog.robot.rendering.world import Solid, World
from facetlog.robot.rendering.worlds import INCH, make_world
from facetlog.robot.simulator.world_file import SceneSetup, SolidSetup

__all__ = ["in_metres", "make_scene"]


def in_metres(world: World) -> World:
    """A world of robot/rendering/worlds.py, whose unit is the inch, with all lengths in metres."""
    solids = tuple(solid.moved(np.eye(3), np.zeros(3), INCH) for solid in world.solids)
    floor = world.floor
    if floor is not None and floor.texture is not None:
        floor = replace(floor, texture=floor.texture.scaled(INCH))
    return replace(world, solids=solids, floor=floor)


def make_scene(setup: SceneSetup) -> World:
    """The world that a scene names, with the solids that it adds.

    >>> [round(side, 4) for side in make_scene(SceneSetup()).solids[0].size]
    [0.254, 0.2032, 0.1524]
    """
    world = in_metres(make_world(setup.world, setup.seed))
    return replace(world, solids=world.solids + tuple(_solid(each) for each in setup.solid))


def _solid(setup: SolidSetup) -> Solid:
    match setup.kind, setup.size:
        case "box", (x, y, z):
            made = cuboid(x, y, z, albedo=setup.albedo)
        case "pyramid", (x, y, z):
            made = pyramid(x, y, z, albedo=setup.albedo)
        case "cylinder", (diameter, height):
            made = cylinder(diameter, height, albedo=setup.albedo)
        case "wedge", (length, side):
            made = wedge(length, side, albedo=setup.albedo)
        case _:
            made = prism(setup.plan, setup.size[0], name="prism", albedo=setup.albedo)
    return placed(made, *setup.at, yaw=float(np.deg2rad(setup.yaw_deg)))
