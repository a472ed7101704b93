"""Within which angle of each other planes count as parallel, and one as upright."""

import numpy as np

# Ten degrees, for whether faces lie in one plane, stand opposite each other, or stand upright.
PARALLEL_COSINE, UPRIGHT_SINE = float(np.cos(np.radians(10.0))), float(np.sin(np.radians(10.0)))
