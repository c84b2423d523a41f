"""The service: what the database knows, over HTTP, to process planning and the shop floor."""
