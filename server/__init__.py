"""The services and the REST interface around the physics: settings, editing, previews and routes."""
