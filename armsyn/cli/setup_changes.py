"""What `armsyn setup` and `armsyn restore` share: showing settings, asking, and telling of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armsyn.cli.prompts import Person
    from armsyn.driver.eeprom import EepromImage
    from armsyn.driver.setup_plan import Change


def changes_table(changes: Sequence[Change]) -> Any:
    """A table of registers, what they hold and what they are to hold."""
    from rich.table import Table

    table = Table("  register", "address", "is", "becomes", box=None)
    for change in changes:
        row = (str(change.register.address), str(change.found), str(change.wanted))
        table.add_row(f"  {change.name}", *row)
    return table


def allowed(changes: Sequence[Change], options: dict[str, Any], person: Person) -> bool:
    """Whether settings may be written: not in a dry run, and only if --yes or the person say so."""
    if options["dry_run"]:
        person.say("dry run: nothing was written")
        return False
    if options["yes"] or person.confirm(f"Write {len(changes)} setting(s)?"):
        return True
    person.say("nothing was written")
    return False


def entry(image: EepromImage, changes: Sequence[Change], *, written: bool) -> dict[str, Any]:
    """A servo's part of the JSON document."""
    found = image.found
    return {
        "model": image.model.name,
        "found": {"id": found.servo_id, "baud": found.baud, "protocol": found.protocol},
        "changes": [
            {
                "register": change.name,
                "address": change.register.address,
                "found": change.found,
                "wanted": change.wanted,
            }
            for change in changes
        ],
        "written": written,
    }
