"""Recordings with effects that their simulation lacks: what an explanation is judged on.

``axis``, ``cuts`` and ``mill`` draw them, ``plan`` says which case a seed is. No effect has a plain
textbook form; every size follows from how clearly the effect shall show.
"""
