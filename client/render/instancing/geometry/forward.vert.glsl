// Hands an instance on to the geometry shader, untouched.
out Instance forwarded;

void main() { forwarded = fetch_instance(); }
