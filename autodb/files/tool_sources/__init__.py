"""What says how a tool is made, besides our own tool files.

``bits``: tool bits of FreeCAD. ``part21``: attribute files of ISO 13399, alone or in a package.
``din4000``: property tables of DIN 4000. ``designations``: codes in a tool's name. Each returns
what a tool file would say.
"""
