"""The house itself: what may be imported from where, and what the package promises."""

import subprocess
import sys


def test_the_knowledge_base_does_not_load_opencv():
    code = "import sys, facetlog.kb; sys.exit('cv2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_worker_loads_for_scenes_only_what_scenes_need():
    heavy = "cv2", "scipy", "trimesh", "lark", "rich"
    code = f"import sys, facetlog.batch.engine; sys.exit(bool({set(heavy)!r} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
