"""One module per DVC stage: `python -m pipeline.<stage> --key value`, in the project's folder."""
