// The only source of each *_floor program, which just has to link (rooms.cmake).
int main() { return 0; }
