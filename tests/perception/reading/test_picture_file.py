"""Pictures are whole or refused, and decoders stay silent."""

import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.perception.reading.picture_file import read_picture
from facetlog.perception.reading.read_views import read_views
from tests.perception.reading.view_folders import picture, write_transforms

KINDS = [".jpg", ".png", ".tiff", ".bmp", ".webp", ".pgm", ".ppm"]


def _written(path: Path) -> bytes:
    image = picture(3)
    colour = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if path.suffix != ".pgm" else image
    cv2.imwrite(str(path), colour)
    return path.read_bytes()


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_file_is_read_in_grey(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"a{kind}"
    _written(path)
    image = read_picture(path)
    assert image.shape == (32, 48)
    loss = np.abs(image.astype(float) - picture(3)).mean()
    assert loss < (12 if kind in (".jpg", ".webp") else 1)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.02, 0.5, 0.97])
def test_a_cut_off_file_is_refused_in_silence(
    tmp_path: Path, kind: str, share: float, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"a{kind}"
    data = _written(path)
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(InputError, match=r"cut off|damaged|not a picture") as caught:
        read_picture(path)
    assert str(path) in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("progressive", [0, 1])
def test_a_jpeg_with_a_hole_and_an_end_is_refused(
    tmp_path: Path, progressive: int, capfd: pytest.CaptureFixture[str]
) -> None:
    big = cv2.resize(picture(3), (480, 320), interpolation=cv2.INTER_NEAREST)
    data = cv2.imencode(".jpg", big, [cv2.IMWRITE_JPEG_PROGRESSIVE, progressive])[1].tobytes()
    path = tmp_path / "a.jpg"
    path.write_bytes(data[: int(len(data) * 0.6)] + b"\xff\xd9")
    with pytest.raises(InputError, match="damaged"):
        read_picture(path)
    assert capfd.readouterr() == ("", "")


def test_a_thumbnail_inside_does_not_end_a_jpeg(tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    data = _written(path)
    thumbnail = b"Exif\0\0" + data
    segment = b"\xff\xe1" + (len(thumbnail) + 2).to_bytes(2, "big") + thumbnail
    path.write_bytes(data[:2] + segment + data[2 : len(data) // 2])
    with pytest.raises(InputError):
        read_picture(path)
    path.write_bytes(data[:2] + segment + data[2:])
    assert read_picture(path).shape == (32, 48)


def test_a_changed_byte_of_a_png_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    data = bytearray(_written(path))
    data[len(data) // 2] ^= 0x40
    path.write_bytes(bytes(data))
    with pytest.raises(InputError, match="damaged"):
        read_picture(path)


def test_sixteen_bits_become_eight(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), picture(3).astype(np.uint16) * 257)
    np.testing.assert_allclose(read_picture(path), picture(3), atol=1)


def test_sixteen_bits_of_which_few_are_used_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), picture(3).astype(np.uint16) << 4)
    with pytest.raises(InputError, match=r"a\.png has 16 bits, yet no level above \d+: write it"):
        read_picture(path)


def test_levels_that_are_no_integers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    cv2.imwrite(str(path), picture(3).astype(np.float32) / 255)
    with pytest.raises(InputError, match=r"a\.tif has levels of float32: write it with 8 or 16"):
        read_picture(path)


@settings(max_examples=80)
@given(
    st.sampled_from(
        [b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"BM", b"P5", b"P6", b"II*\0", b"RIFF"]
    ),
    st.binary(max_size=80),
)
def test_no_bytes_make_the_reader_fail_otherwise(
    tmp_path_factory: pytest.TempPathFactory, start: bytes, rest: bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / "fuzz"
    path.write_bytes(start + rest)
    try:
        assert read_picture(path).ndim == 2
    except InputError:
        return


def test_heic_is_read_by_its_extra(tmp_path: Path) -> None:
    heif = pytest.importorskip("pillow_heif", reason="the extra heic is not installed")
    levels = np.tile(np.arange(0, 240, 4, dtype=np.uint8), (48, 1))
    path = tmp_path / "a.heic"
    colour = np.repeat(levels[..., None], 3, axis=2)
    heif.from_bytes("RGB", (60, 48), colour.tobytes()).save(path, quality=95)
    found = read_picture(path)
    assert found.shape == (48, 60)
    assert np.abs(found.astype(int) - levels).mean() < 4
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(InputError, match="damaged"):
        read_picture(path)


def test_without_its_extra_heic_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    (tmp_path / "a.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(40))
    with pytest.raises(InputError, match=r"a\.heic: HEIC .* pip install 'facetlog\[heic\]'"):
        read_picture(tmp_path / "a.heic")


def claim_size(jpeg: bytes, width: int, height: int) -> bytes:
    """The JPEG with another size in its frame header (ITU-T T.81, B.2.2)."""
    at = jpeg.index(b"\xff\xc0") + 5
    return jpeg[:at] + height.to_bytes(2, "big") + width.to_bytes(2, "big") + jpeg[at + 4 :]


def test_a_header_of_a_gigapixel_is_refused_before_it_is_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.jpg"
    whole = cv2.imencode(".jpg", picture())[1].tobytes()
    path.write_bytes(claim_size(whole, 32_000, 32_000))
    monkeypatch.setattr(cv2, "imdecode", None)
    with pytest.raises(InputError, match="32000 x 32000 by its header"):
        read_picture(path)


def test_a_picture_that_is_not_of_its_cameras_size_is_not_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_transforms(tmp_path)
    (folder / "images" / "1.png").write_bytes(
        claim_size(cv2.imencode(".jpg", picture())[1].tobytes(), 9_000, 9_000)
    )
    decode, sizes = cv2.imdecode, []

    def decoded(*given: Any) -> Any:
        image = decode(*given)
        sizes.append(image.shape)
        return image

    monkeypatch.setattr(cv2, "imdecode", decoded)
    found = read_views(folder)
    assert len(found.views) == 2
    assert "the picture is 9000 x 9000, its camera says 48 x 32" in found.problems[0]
    assert set(sizes) == {(32, 48)}
