"""Numbers with names: what any result becomes as labelled arrays (xarray), as a data frame (pandas), as netCDF."""
