// A line below the header while the server is away.

import { connection } from "../lib/connection.ts";
import { Message } from "./message.tsx";

const WORDS = {
  there: "",
  lost: "The connection to the server is lost; trying again … What you do is kept in this browser, and goes on when “martensite app” runs again on the same port.",
  stranger: "The server was started anew and does not know this browser: open the address that “martensite app” printed, in any tab. This one then goes on where it was.",
};

export function Connection() {
  const words = WORDS[connection.value];
  return <div class="connection">{words && <Message kind="caution">{words}</Message>}</div>;
}
