"""What all tests share."""

import os

os.environ.pop("ALFWORLD_DATA", None)  # so that games are generated, here and in other processes
