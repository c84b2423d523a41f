"""Proofs on virtual machines: do the intervals that autodb gives hold the truth as often as stated?

``score`` judges intervals, ``oracle`` is what could be had at best, ``run_file`` keeps finished
runs, ``proof_summary`` makes the table of intervals; ``autodb.proofs.catalogue`` lists all proofs.
"""
