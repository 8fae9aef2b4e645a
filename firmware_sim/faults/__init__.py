"""Named faults: what goes wrong on a servo bus, on request.

`registry` knows all kinds, `parsing` reads them from text and `scenario` from TOML files, `roster`
keeps those in force, and `seam` is where bytes meet them.
"""
