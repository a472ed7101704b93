"""Writes the VS Code extension of editors/vscode as one file that `code --install-extension` takes.

A .vsix is a zip file: the extension's files in `extension/`, a manifest, and the types of its
files. The same files make the same bytes.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

ROOT = Path(__file__).resolve().parent.parent
EXTENSION = ROOT / "editors" / "vscode"

SUFFIXES = {
    ".json": "application/json",
    ".js": "application/javascript",
    ".md": "text/markdown",
    ".txt": "text/plain",
    ".vsixmanifest": "text/xml",
}
"""The files of an extension; whatever else lies in its folder is none."""

MANIFEST = """\
<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id={name} Version={version} Publisher={publisher}/>
    <DisplayName>{title}</DisplayName>
    <Description xml:space="preserve">{description}</Description>
    <Categories>{categories}</Categories>
    <License>extension/LICENSE.txt</License>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value={engine}/>
    </Properties>
  </Metadata>
  <Installation>
    <InstallationTarget Id="Microsoft.VisualStudio.Code"/>
  </Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest"
      Path="extension/package.json" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.Details"
      Path="extension/README.md" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.License"
      Path="extension/LICENSE.txt" Addressable="true"/>
  </Assets>
</PackageManifest>
"""


def manifest(package: Mapping[str, object]) -> str:
    """Return the manifest of an extension, made from its package.json."""
    engines, categories = package["engines"], package["categories"]
    return MANIFEST.format(
        name=quoteattr(str(package["name"])),
        version=quoteattr(str(package["version"])),
        publisher=quoteattr(str(package["publisher"])),
        title=escape(str(package["displayName"])),
        description=escape(str(package["description"])),
        categories=escape(",".join(categories)),  # type: ignore[arg-type]
        engine=quoteattr(engines["vscode"]),  # type: ignore[index]
    )


def types() -> str:
    """Return the types of the files by their endings."""
    rows = "".join(
        f'<Default Extension="{suffix}" ContentType="{kind}"/>' for suffix, kind in SUFFIXES.items()
    )
    address = "http://schemas.openxmlformats.org/package/2006/content-types"
    return f'<?xml version="1.0" encoding="utf-8"?>\n<Types xmlns="{address}">{rows}</Types>\n'


def entries(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Return the names of all files of the .vsix, and what they hold."""
    package = json.loads((folder / "package.json").read_text(encoding="utf-8"))
    yield "extension.vsixmanifest", manifest(package).encode()
    yield "[Content_Types].xml", types().encode()
    yield "extension/LICENSE.txt", (ROOT / "LICENSE").read_bytes()
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder)
        if path.is_file() and path.suffix in SUFFIXES and inside.parts[0] != "node_modules":
            yield f"extension/{inside.as_posix()}", path.read_bytes()


def build(folder: Path, out: Path) -> None:
    """Write a .vsix; its entries have the date of the format's beginning, so that bytes stay."""
    out.parent.mkdir(parents=True, exist_ok=True)
    with ZipFile(out, "w", ZIP_DEFLATED) as archive:
        for name, content in entries(folder):
            archive.writestr(ZipInfo(name), content, ZIP_DEFLATED)


def main(arguments: list[str]) -> int:
    """Write the file, and its path on standard output."""
    package = json.loads((EXTENSION / "package.json").read_text(encoding="utf-8"))
    default = ROOT / "dist" / f"{package['name']}-{package['version']}.vsix"
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=default)
    out = parser.parse_args(arguments).out
    build(EXTENSION, out)
    print(out)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
