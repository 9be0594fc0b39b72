// Sprites are made where they are drawn. The desktop player lists them beforehand.
Sprite fetch_sprite(int i) { return make_sprite(fetch_instance(i)); }
