"""Our server, which also appends every transport message of its stage to the file that is its argument."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from improv_core.safety.stops import Stops
from improv_core.session import session as client
from improv_core.session.acts import News
from improv_core.session.start import Options
from improv_ls.__main__ import main

TAP = Path(sys.argv.pop(1))


class Tapped(client.Playback):
    def __init__(self, options: Options, listen: Callable[[News, bool], None], stops: Stops, **others: Any) -> None:
        def tell(message: News, leads: bool) -> None:
            with TAP.open("a", encoding="utf-8") as tap:
                tap.write(json.dumps(message) + "\n")
            listen(message, leads)

        super().__init__(options, tell, stops, **others)


if __name__ == "__main__":
    client.Playback = Tapped  # type: ignore[assignment, misc]
    main()
