#include "app.h"

void setup() { app_begin(); }

void loop() { app_turn(); }
