// A line below the header while the server is away.

import { connection } from "../lib/connection.ts";
import { Message } from "./message.tsx";

const WORDS = {
  there: "",
  lost: "The connection to the server is lost; trying again … Your work is stored in this browser and continues when “martensite app” runs again on the same port.",
  stranger: "The server was restarted and does not know this browser. “martensite app” printed an address. Open it in any tab, and this tab continues.",
};

export function Connection() {
  const words = WORDS[connection.value];
  return <div class="connection">{words && <Message kind="caution">{words}</Message>}</div>;
}
