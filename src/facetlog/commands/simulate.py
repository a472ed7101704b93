"""`facetlog simulate`: a simulated Pioneer with a camera on a pan-tilt head."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.shared import YES, command

__all__ = ["simulate_command"]

ROBOT, CAMERA = "127.0.0.1:8101", "127.0.0.1:8100"


@command
def simulate_command(
    listen: Annotated[
        str,
        typer.Option(
            "--listen", metavar="HOST:PORT", help="Address of the robot; port 0: any free."
        ),
    ] = ROBOT,
    world: Annotated[
        Path | None,
        typer.Option("--world", metavar="FILE", help="World to simulate (see docs/simulator.md)."),
    ] = None,
    pty: Annotated[
        bool, typer.Option("--pty", help="Also offer the robot at a pseudo terminal.")
    ] = False,
    camera: Annotated[
        str,
        typer.Option(
            "--camera", metavar="HOST:PORT", help="HTTP address of camera, state and faults."
        ),
    ] = CAMERA,
    seed: Annotated[
        int | None, typer.Option("--seed", metavar="N", help="Seed of slip and noise.", min=0)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the addresses as JSON.")] = False,
) -> int:
    """Simulate a robot, its world and its camera, and print their addresses, until Ctrl-C."""
    from facetlog.robot.simulator.station import Station
    from facetlog.robot.simulator.world_file import read_world

    setup = read_world(world)
    if seed is not None:
        setup = replace(setup, seed=seed)
    with Station(setup, listen=listen, pty=pty, camera=camera) as station:
        station.draw_first()
        typer.echo(station.addresses.json if as_json else station.addresses.text)
        station.run()
    return YES
