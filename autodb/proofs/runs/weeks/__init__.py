"""A lathe's weeks: every file of cuts is predicted before it comes in; what happens is named."""
