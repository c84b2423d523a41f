"""Proofs on virtual machines: do the intervals that autodb gives hold the truth as often as stated?

``score`` judges intervals, ``oracle`` is what could be had at best, ``axis_intervals`` one proof,
``proofs`` lists them all; ``runs`` keeps finished runs in a file, ``summary`` makes the table.
"""
