"""Values as JSON text."""

import json
from typing import Any


def to_json(value: Any) -> str:
    """JSON of a value that may hold NumPy arrays and numbers."""
    return json.dumps(value, default=lambda item: item.tolist(), ensure_ascii=False)
