// Where one begins: the questions that people come with, each with a picture.

import { PICTURES } from "../start/pictures.tsx";
import { DOORS, openDoor, shut, type Door } from "../start/doors.ts";
import { isOffered } from "../state/route.ts";
import { text } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";

function Entrance({ door }: { door: Door }) {
  const Picture = PICTURES[door.key];
  const open = (event: Event): void => {
    if (!door.scenario) return;
    event.preventDefault();
    void openDoor(door.scenario);
  };
  return (
    <li>
      <a class="door panel" href={`#/${door.page}`} onClick={open}>
        {Picture && <Picture />}
        <h2>{door.title}</h2>
        <p class="small soft">{door.about}</p>
      </a>
    </li>
  );
}

export function Page() {
  return (
    <div class="start stack">
      <h1>What do you want to know?</h1>
      <p class="soft start-about">A test bench for shape-memory-alloy (nitinol) actuators: change a parameter and see stroke, temperature and time.</p>
      {shut.value && <Message kind="error">{shut.value}</Message>}
      <ul class="doors">
        {DOORS.filter(({ page }) => isOffered(page.split("?")[0]!)).map((door) => (
          <Entrance key={door.key} door={door} />
        ))}
      </ul>
      <p class="small">
        <a href="#/bench">{text.value ? "Back to the bench" : "Open the bench with all packaged scenarios"}</a>
      </p>
    </div>
  );
}
