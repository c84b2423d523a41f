"""Virtual lathes: process, drives, jobs, days and fleets."""
