/** A running team whose agents have computers of their own: leaders, duties by order, and missing agents. */

import { useState } from "preact/hooks";
import { Button, ControlButton } from "./button";
import { Confirm } from "./confirm";
import { useStudio } from "./context";
import type { Studio } from "./studio";
import type { Team, TeamAgent } from "./protocol";
import { className, plain } from "./words";

export function TeamView() {
  const studio = useStudio();
  const { team } = studio;
  if (team === null) return null;
  const squads = team.agents.filter(({ is_robot }) => !is_robot);
  const loose = team.agents.filter(({ is_robot, squad }) => is_robot && squad === null);
  return (
    <main class="team" aria-label="Team">
      <Summary team={team} />
      {squads.map((squad) => (
        <SquadSection key={squad.name} team={team} squad={squad} />
      ))}
      {loose.length > 0 && (
        <section>
          <header class="flex wrap squad">
            <h2>In no squad</h2>
          </header>
          <ul>
            {loose.map((agent) => (
              <AgentRow key={agent.name} agent={agent} />
            ))}
          </ul>
        </section>
      )}
    </main>
  );
}

function Summary({ team }: { team: Team }) {
  const describeSilence = team.agents.filter(({ presence }) => presence !== "here");
  const differing = team.agents.filter(({ other_library }) => other_library);
  return (
    <div class="summary" role="status">
      <h2 class="name">Team {plain(team.name)}</h2>
      <span class="soft">
        {team.agents.length - describeSilence.length} of {team.agents.length} agents are heard
      </span>
      {describeSilence.length > 0 && <span class="warn">Not heard: {names(describeSilence)}</span>}
      {differing.length > 0 && (
        <span class="warn">
          With another library than here: {names(differing)}. <code>understudy team push</code> hands them
          this one.
        </span>
      )}
    </div>
  );
}

function SquadSection({ team, squad }: { team: Team; squad: TeamAgent }) {
  const members = team.agents.filter((agent) => agent.squad === squad.name);
  const leader = leaderOf(team, squad.name);
  return (
    <section aria-label={squad.name}>
      <header class="flex wrap squad">
        <h2>{squad.name}</h2>
        <span class={className(leader === null && "warn")}>
          {leader === null ? (
            "without a leader"
          ) : (
            <>
              led by <b>{leader}</b>
              <span class="soft">, term {termOf(team, squad.name)}</span>
            </>
          )}
        </span>
        {leader !== null && <Activity agent={squad} />}
        {squad.presence !== "here" && <span class="warn">its own agent {describeSilence(squad)}</span>}
        <OrderCell agent={squad} />
        <span class="space" />
        <Train agent={squad} />
      </header>
      <ul>
        {members
          .filter(({ is_robot }) => is_robot)
          .map((agent) => (
            <AgentRow key={agent.name} agent={agent} />
          ))}
      </ul>
    </section>
  );
}

function AgentRow({ agent }: { agent: TeamAgent }) {
  const studio = useStudio();
  const [asks, setAsks] = useState(false);
  const here = agent.presence === "here";
  return (
    <li class={className("agent", agent.presence)} aria-label={agent.name}>
      <span class="who">
        <span
          class={className("light", agent.armed === true && (agent.problem === "" ? "moves" : "waits"))}
          title={agent.armed === true ? "armed" : "not armed"}
        />
        <b>{agent.name}</b>
      </span>
      {here ? <Activity agent={agent} /> : <span class="doing warn">{describeSilence(agent)}</span>}
      <OrderCell agent={agent} />
      <span class="notes">
        {here && agent.problem !== "" && <span class="warn">not counted: {agent.problem}</span>}
        {agent.trainer !== "" && <span class="trained">trained from {agent.trainer}</span>}
        {agent.other_library && <span class="warn">another library</span>}
      </span>
      <span class="flex wrap does">
        {asks ? (
          <Confirm
            label={`Arm ${agent.name}`}
            onConfirm={() => void studio.ask({ do: "arm_robot", name: agent.name })}
            onClose={() => setAsks(false)}
          >
            <span class="soft">It will move.</span>
          </Confirm>
        ) : (
          <>
            <ControlButton disabled={!here || agent.armed === true} onClick={() => setAsks(true)}>
              {agent.armed === true ? "Armed" : "Arm…"}
            </ControlButton>
            <Button
              class="halt"
              aria-label={`Stop ${agent.name}`}
              onClick={() => void studio.ask({ do: "stop_robot", name: agent.name })}
            >
              Stop
            </Button>
            <Train agent={agent} />
          </>
        )}
      </span>
    </li>
  );
}

function Activity({ agent }: { agent: TeamAgent }) {
  const path = [...(agent.duty === "" ? [] : [agent.duty]), ...agent.states];
  return (
    <span class="doing">
      {path.length === 0 ? <span class="soft">nothing</span> : path.map(plain).join(" › ")}
    </span>
  );
}

function OrderCell({ agent }: { agent: TeamAgent }) {
  if (agent.order === null) {
    const alone = agent.is_robot && agent.presence === "here" && agent.trainer === "";
    return <span class="order soft">{alone ? "alone, without an order" : ""}</span>;
  }
  return (
    <span class="order" title={`Order ${agent.order}: the term of its leader, and its number in it`}>
      order <b>{agent.order}</b> <span class="soft">from {agent.leader}</span>
      {agent.order_age_s !== null && <span class="soft"> for {duration(agent.order_age_s)}</span>}
    </span>
  );
}

function Train({ agent }: { agent: TeamAgent }) {
  const studio = useStudio();
  const why =
    studio.team?.trainer === null
      ? 'Add trainer = "NAME" to [agents] in the team\'s file to train over the network'
      : agent.is_robot
        ? "Train this robot from here"
        : "Train the coordinator from here";
  return (
    <ControlButton
      title={why}
      disabled={studio.team?.trainer === null}
      onClick={() => void train(studio, agent)}
    >
      Train
    </ControlButton>
  );
}

async function train(studio: Studio, agent: TeamAgent): Promise<void> {
  const number = agent.is_robot ? (studio.scene?.real_robots.indexOf(agent.name) ?? 0) : 0;
  const answer = await studio.ask({
    do: "select_agent",
    agent: number,
    sort: agent.is_robot ? null : agent.sort,
  });
  if (answer.error === undefined) studio.switchView("training");
}

/** The agent that leads a squad: of several that believe to, that of the highest term. */
function leaderOf(team: Team, squad: string): string | null {
  const leading = team.agents.filter(({ leads }) => squad in leads);
  leading.sort((one, other) => (other.leads[squad] ?? 0) - (one.leads[squad] ?? 0));
  return leading[0]?.name ?? null;
}

function termOf(team: Team, squad: string): number {
  return Math.max(0, ...team.agents.map(({ leads }) => leads[squad] ?? 0));
}

function describeSilence(agent: TeamAgent): string {
  if (agent.presence === "gone") return "is not there";
  return agent.silent_s === null ? "is silent" : `is silent for ${duration(Math.max(1, agent.silent_s))}`;
}

function names(agents: readonly TeamAgent[]): string {
  return agents.map(({ name }) => name).join(", ");
}

/** A time in s, as a person says it: 14 s, 3 min. */
export function duration(seconds: number): string {
  return seconds < 100 ? `${String(seconds)} s` : `${String(Math.round(seconds / 60))} min`;
}
