// Forwards an instance to the geometry shader.
out Instance forwarded;

void main() { forwarded = fetch_instance(); }
