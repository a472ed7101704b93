"""What all tests of the driver share."""

import pytest

from facetlog.robot.pioneer import opening


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Listens for three reports of the scripted robot's, which come twice as fast."""
    monkeypatch.setattr(opening, "LISTEN", 0.17)
