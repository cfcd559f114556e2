"""The service: FastAPI over gallery and studio, and the built pages of the front end."""
