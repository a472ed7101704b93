"""The floor as a map of ROS: a picture (PGM) and what says how to read it (YAML).

The form is that of ROS 1's map_server, which ROS 2's nav2_map_server reads too: a pixel of grey g
is occupied with the probability (255 - g) / 255, which above `occupied_thresh` counts as occupied,
below `free_thresh` as free, and else as unknown (its mode "trinary"). Row 0 of the picture is the
highest y; `origin` is the lower left corner of the lower left pixel in the frame of the map.
"""

from facetlog.mapping.floor_grid import Cell, FloorGrid

__all__ = ["PGM_FILE", "YAML_FILE", "pgm_bytes", "yaml_text"]

PGM_FILE, YAML_FILE = "map.pgm", "map.yaml"
# The greys that map_saver writes: what only sonars passed is not known to be free.
GREYS = {Cell.UNSEEN: 205, Cell.PASSED: 205, Cell.FREE: 254, Cell.OCCUPIED: 0}
# The thresholds that map_saver writes; 205 is between them.
OCCUPIED, FREE = 0.65, 0.196


def pgm_bytes(floor: FloorGrid) -> bytes:
    """The picture in Netpbm's binary form (P5), one byte a cell."""
    import numpy as np

    greys = np.zeros(len(Cell), np.uint8)
    for state, grey in GREYS.items():
        greys[state] = grey
    picture = greys[floor.cells[::-1]]
    rows, columns = picture.shape
    head = f"P5\n# facetlog: {floor.side:g} m a pixel\n{columns} {rows}\n255\n"
    return head.encode("ascii") + picture.tobytes()


def yaml_text(floor: FloorGrid, picture: str = PGM_FILE) -> str:
    """What says how to read the picture of that name beside it."""
    x, y = (round(value, 9) for value in floor.low)
    return (
        f"image: {picture}\n"
        "mode: trinary\n"
        f"resolution: {floor.side!r}\n"
        f"origin: [{x!r}, {y!r}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED}\n"
        f"free_thresh: {FREE}\n"
    )
