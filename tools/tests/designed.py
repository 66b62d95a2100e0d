"""designed.py FOLDER CORE...: designs of five models, with what they are promised to cost there."""

from __future__ import annotations

import sys
from pathlib import Path

import five
from design_models import write
from kalmanq.firmware.designs import Part, design
from kalmanq.firmware.reach import draw
from kalmanq.run.parts import Parts

ROOMY = 1 << 24


def main() -> None:
    folder, cores = Path(sys.argv[1]), sys.argv[2:]
    for make in five.FIVE:
        model = make()
        records = draw(model)
        whole = draw(model.changed(gaps=type(model.gaps)()), seeds=[1])[0]  # without gaps: what a step costs
        for core in cores:
            made = design(model, Part(core, ROOMY, ROOMY), records)
            for arithmetic in ("f32", "q31"):
                chosen = made.chosen(arithmetic)
                assert chosen, f"{model.name} on {core}: nothing is good in {arithmetic}"
                promised = {"instructions": chosen.cost.instructions, "flash": chosen.cost.flash,
                            "ram": chosen.cost.ram}
                write(folder, f"{model.name}_{arithmetic}_{chosen.way}_{core}", Parts(model, arithmetic), chosen.way,
                      whole, {"cores": [core], "promises": {core: promised}})


if __name__ == "__main__":
    main()
