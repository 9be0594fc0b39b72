// The whole of each *_floor program: only whether it links matters (rooms.cmake).
int main() { return 0; }
