"""One line for each kind of fault for which pictures are left out."""

from facetlog.perception.reading.left_out import LeftOut, lines_of


def of_16_bits(k: int) -> LeftOut:
    return LeftOut(f"{k}.png", f"picture /a/{k}.png has 16 bits: write 8", f"/a/{k}.png")


def missing(k: int) -> LeftOut:
    return LeftOut(f"{k}.png", f"picture /a/{k}.png is missing: put it there", f"/a/{k}.png")


def test_each_kind_of_fault_has_a_line() -> None:
    lines = lines_of([of_16_bits(0), missing(1), of_16_bits(2)])
    assert lines == (
        "picture /a/0.png has 16 bits: write 8; left out, and so is 2.png",
        "picture /a/1.png is missing: put it there; left out",
    )
