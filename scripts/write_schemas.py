"""Write the JSON Schemas of facetlog's files into out/schemas; `make docs` runs it."""

import json
from pathlib import Path

from facetlog.batch.rows import RowRecord
from facetlog.mapping.map_record import MapRecord
from facetlog.perception.surfaces.scene_json.records import SceneRecord
from facetlog.verdicts_schema import VerdictsRecord

RECORDS = {"scene": SceneRecord, "verdicts": VerdictsRecord, "map": MapRecord, "results": RowRecord}
FOLDER = Path(__file__).resolve().parent.parent / "out" / "schemas"

if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, record in RECORDS.items():
        text = json.dumps(record.model_json_schema(), indent=2) + "\n"
        (FOLDER / f"{name}.schema.json").write_text(text, encoding="utf-8")
