"""The service: what the database holds, over HTTP, to process planning and the shop floor."""
