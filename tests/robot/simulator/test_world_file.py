"""The world file: what the default says, and refusals that name line and key."""

from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.robot.pioneer.packets.reports import Configuration
from facetlog.robot.simulator.body import MotionErrors
from facetlog.robot.simulator.faults import Fault, FaultKind
from facetlog.robot.simulator.simulation import Simulation
from facetlog.robot.simulator.world_file import ErrorSetup, read_world


def world(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "world.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_default_world_documents_every_key_with_its_default(tmp_path: Path) -> None:
    documented = read_world()
    empty = read_world(world(tmp_path, ""))
    assert empty == replace(documented, robot=replace(documented.robot, errors=ErrorSetup()))
    assert empty.robot.motion_errors == documented.robot.motion_errors
    content = (Path(__file__).parents[3] / "robot/simulator/default_world.toml").read_text()
    for table in (documented.robot, documented.head, documented.mount, documented.camera):
        for key in table.__slots__:
            assert key in content


def test_wheels_slip_unless_they_are_said_to_be_perfect(tmp_path: Path) -> None:
    def errors(text: str) -> MotionErrors:
        return read_world(world(tmp_path, f"[robot]\n{text}")).robot.motion_errors

    usual = errors("")
    assert usual.slip > 0
    assert errors("model = 'p3at'").slip > usual.slip
    assert errors("odometry = 'perfect'") == MotionErrors()
    assert errors("errors = { slip = 0.05 }") == replace(usual, slip=0.05)
    stated = errors("odometry = 'perfect'\nerrors = { slip = 0.05 }")
    assert stated == MotionErrors(slip=0.05)


def test_everything_can_be_said(tmp_path: Path) -> None:
    text = """
    seed = 7
    [scene]
    world = "table"
    seed = 3
    [[scene.solid]]
    kind = "box"
    size = [0.3, 0.2, 0.1]
    at = [2, 0.5]
    [robot]
    model = "p3dx"
    start = { x = 1, heading_deg = 90 }
    [robot.config]
    watchdog_ms = 1000
    name = "Other"
    [head]
    kind = "canon-vc-c4"
    port = "own"
    own = "pty"
    [mount]
    pinhole_ahead = 0.03
    [camera]
    noise = 0
    [[faults]]
    at = 3.5
    fault = { kind = "corrupt", rate = 0.1, seconds = 2 }
    """
    setup = read_world(world(tmp_path, text))
    assert setup.scene.solid[0].at == (2.0, 0.5)
    assert setup.robot.start.heading_deg == 90
    assert setup.faults[0].fault == Fault(FaultKind.CORRUPT, rate=0.1, seconds=2.0)
    told: Configuration = Simulation(setup).firmware.drive.configuration
    assert (told.watchdog_ms, told.name) == (1000, "Other")


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("[camera]\nwidth = 640\nwide = 3\n", 3, "camera.wide: there is no such key"),
        ("[camera]\n\nnoise = -1\n", 3, "camera.noise: input should be greater than or equal to 0"),
        ('[scene]\nworld = "castle"\n', 2, "scene.world: no world 'castle'; there are block,"),
        ('# x\n[robot]\nmodel = "p9"\n', 3, "robot.model: no model 'p9'; there are p2dx,"),
        ("[robot.config]\nwatchdog = 3\n", 2, "there is no such field in a CONFIG packet"),
        ("[robot.config]\nspeed_max = -3\n", 2, "give a number from 0 to 65535"),
        ("[robot.config]\nfirmware = 3\n", 2, "robot.config.firmware: give a text"),
        ("[robot]\nstart = { x = 'a' }\n", 2, "robot.start.x: input should be a valid number"),
        ("[mount]\nz = nan\n", 2, "mount.z: input should be a finite number"),
        ("robot = 3\n", 1, "robot: input should be"),
        (
            '[[faults]]\nat = 1\nfault = { kind = "lost" }\n[[faults]]\nat = 2\n'
            'fault = { kind = "burnt" }\n',
            6,
            "faults.1.fault.kind: input should be 'lost', 'corrupt'",
        ),
        (
            '[[scene.solid]]\nkind = "box"\nsize = [1, 2]\n',
            3,
            "scene.solid.0.size: a box has 3 lengths here, not 2",
        ),
        (
            '[[scene.solid]]\nkind = "prism"\nsize = [1]\nplan = [[0, 0], [1, 0]]\n',
            3,
            "a prism needs a plan of three points or more",
        ),
        ('[head]\nport = "aux4"\n', 2, "head.port: input should be 'aux1', 'aux2', 'aux3' or"),
    ],
)
def test_a_fault_is_reported_with_file_line_and_key(
    tmp_path: Path, text: str, line: int, said: str
) -> None:
    path = world(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_world(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: ")
    assert said in message
    assert "\n" not in message


def test_what_is_not_toml_or_not_there_is_reported_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"not TOML: .*line 1.*correct it there"):
        read_world(world(tmp_path, "[scene\n"))
    with pytest.raises(InputError, match="cannot be read"):
        read_world(tmp_path / "missing.toml")
    (tmp_path / "latin.toml").write_bytes(b"# \xe9\n")
    with pytest.raises(InputError, match="not UTF-8"):
        read_world(tmp_path / "latin.toml")
