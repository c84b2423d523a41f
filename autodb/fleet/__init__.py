"""Many machines at once: their refreshes spread over processes, here or elsewhere, by Dask."""
