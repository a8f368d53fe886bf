"""Work spread over the processes of a Dask cluster: who may compute, what is sent, what to do when one is gone."""
