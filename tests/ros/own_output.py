"""Reserve standard output for us when imported: output of DDS there would tear our lines."""

import os
import sys

sys.stdout = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)
