// Asks the analyser, through rb-web, for the data of the visible plots, once a second while they are visible.
import type {ChannelId} from "./channels";
import {encode} from "./encode";
import {sessionToken} from "./feed";
import {kView, type View} from "./wire";

/** How spectra are made. */
export interface Spectral {
  readonly segment: number;
  readonly window: number;
  readonly memory: number;
  readonly holdPeaks: boolean;
  readonly overlap: number;
  readonly highestHz: number;
}

export interface Wish {
  readonly pairs?: readonly (readonly [ChannelId, ChannelId])[];
  readonly spectra?: readonly ChannelId[];
  readonly envelopes?: readonly ChannelId[];
  readonly waterfalls?: readonly {readonly wheel: number; readonly channel: ChannelId}[];
}

/** As in view_t. */
export const kMostPairs = 16, kMostChannels = 16, kMostWaterfalls = 4;

export function viewOf(viewer: number, spectral: Spectral, wish: Wish): View {
  const pairs = (wish.pairs ?? []).slice(0, kMostPairs);
  const spectra = (wish.spectra ?? []).slice(0, kMostChannels);
  const envelopes = (wish.envelopes ?? []).slice(0, kMostChannels);
  const waterfalls = (wish.waterfalls ?? []).slice(0, kMostWaterfalls);
  return {
    viewer, segment: spectral.segment, window: spectral.window, memory: spectral.memory,
    hold_peaks: spectral.holdPeaks ? 1 : 0, overlap: spectral.overlap, highest_hz: spectral.highestHz,
    pairs: pairs.length,
    input_node: pairs.map(([input]) => input.node), input_channel: pairs.map(([input]) => input.channel),
    output_node: pairs.map(([, output]) => output.node), output_channel: pairs.map(([, output]) => output.channel),
    spectra: spectra.length, spectrum_node: spectra.map(({node}) => node), spectrum_channel: spectra.map(({channel}) => channel),
    envelopes: envelopes.length,
    envelope_node: envelopes.map(({node}) => node), envelope_channel: envelopes.map(({channel}) => channel),
    waterfalls: waterfalls.length, waterfall_wheel: waterfalls.map(({wheel}) => wheel),
    waterfall_node: waterfalls.map(({channel}) => channel.node),
    waterfall_channel: waterfalls.map(({channel}) => channel.channel),
  };
}

/** What went wrong, for people; empty: nothing. */
export async function ask(view: View): Promise<string> {
  try {
    const answer = await fetch("/view", {
      method: "POST", body: encode(kView, view),
      headers: {"Content-Type": "application/octet-stream", "X-Roadbalance-Token": sessionToken()}});
    if (answer.ok) return "";
    return (await answer.text()).trim() || `rb-web refuses to ask for plots (${answer.status}).`;
  } catch {
    return "This page does not reach rb-web.";
  }
}
