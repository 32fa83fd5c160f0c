// Encoded pictures as a WebM file: the part of Matroska (RFC 9559, in the EBML of RFC 8794) that a silent film needs.

export interface Picture {
  /** µs from the beginning; whole milliseconds of it are kept. */
  time: number;
  /** Can be decoded without those before it. */
  key: boolean;
  data: Uint8Array;
}

export interface Film {
  codec: "V_VP8" | "V_VP9" | "V_AV1";
  width: number;
  height: number;
  /** In time's order, the first a key. */
  pictures: Picture[];
  /** µs that the last picture stands. */
  last: number;
}

type Bytes = Uint8Array;

const ids = {
  EBML: 0x1a45dfa3, EBMLVersion: 0x4286, EBMLReadVersion: 0x42f7, EBMLMaxIDLength: 0x42f2, EBMLMaxSizeLength: 0x42f3,
  DocType: 0x4282, DocTypeVersion: 0x4287, DocTypeReadVersion: 0x4285,
  Segment: 0x18538067,
  Info: 0x1549a966, TimestampScale: 0x2ad7b1, Duration: 0x4489, MuxingApp: 0x4d80, WritingApp: 0x5741,
  Tracks: 0x1654ae6b, TrackEntry: 0xae, TrackNumber: 0xd7, TrackUID: 0x73c5, TrackType: 0x83, FlagLacing: 0x9c, CodecID: 0x86,
  Video: 0xe0, PixelWidth: 0xb0, PixelHeight: 0xba,
  Cues: 0x1c53bb6b, CuePoint: 0xbb, CueTime: 0xb3, CueTrackPositions: 0xb7, CueTrack: 0xf7, CueClusterPosition: 0xf1,
  Cluster: 0x1f43b675, Timestamp: 0xe7, SimpleBlock: 0xa3,
} as const;

function joined(parts: Bytes[]): Bytes {
  const all = new Uint8Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** Big-endian, in `bytes` bytes or as few as hold it. */
function whole(value: number, bytes = 0): Bytes {
  const digits: number[] = [];
  for (let rest = value; rest > 0 || digits.length < Math.max(bytes, 1); rest = Math.floor(rest / 256)) digits.unshift(rest % 256);
  return Uint8Array.from(digits);
}

function real(value: number): Bytes {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
}

const text = (value: string) => new TextEncoder().encode(value);

/** Its size is written in 8 bytes, so that sizes are known before the content is. */
function element(name: keyof typeof ids, ...content: Bytes[]): Bytes {
  const size = whole(content.reduce((sum, { length }) => sum + length, 0), 8);
  size[0] = 0x01;
  return joined([whole(ids[name]), size, ...content]);
}

function header(): Bytes {
  const numbers = { EBMLVersion: 1, EBMLReadVersion: 1, EBMLMaxIDLength: 4, EBMLMaxSizeLength: 8, DocTypeVersion: 4, DocTypeReadVersion: 2 } as const;
  const fields = Object.entries(numbers).map(([name, value]) => element(name as keyof typeof numbers, whole(value)));
  return element("EBML", ...fields, element("DocType", text("webm")));
}

const milliseconds = (time: number) => Math.round(time / 1000);

/** From one key picture to the next: a block's time is within 32 s of its cluster's. */
function clusters(pictures: Picture[]): Picture[][] {
  const groups: Picture[][] = [];
  for (const picture of pictures) {
    const group = groups[groups.length - 1];
    if (!group || picture.key || picture.time - group[0].time > 30e6) groups.push([picture]);
    else group.push(picture);
  }
  return groups;
}

function cluster(group: Picture[]): Bytes {
  const start = milliseconds(group[0].time);
  const blocks = group.map(({ time, key, data }) => element("SimpleBlock", Uint8Array.of(0x81), whole(milliseconds(time) - start, 2), Uint8Array.of(key ? 0x80 : 0), data));
  return element("Cluster", element("Timestamp", whole(start)), ...blocks);
}

/** The file; where a player may jump to stands before the pictures. */
export function webm({ codec, width, height, pictures, last }: Film): Uint8Array {
  const groups = clusters(pictures);
  const end = pictures.length > 0 ? pictures[pictures.length - 1].time + last : 0;
  const app = text("mimbre");
  const info = element("Info", element("TimestampScale", whole(1e6)), element("Duration", real(end / 1000)), element("MuxingApp", app), element("WritingApp", app));
  const video = element("Video", element("PixelWidth", whole(width)), element("PixelHeight", whole(height)));
  const track = element("TrackEntry", element("TrackNumber", whole(1)), element("TrackUID", whole(1)), element("TrackType", whole(1)), element("FlagLacing", whole(0)), element("CodecID", text(codec)), video);
  const tracks = element("Tracks", track);
  const content = groups.map(cluster);
  const cues = (first: number) => {
    let at = first;
    const points = groups.map((group, k) => {
      const positions = element("CueTrackPositions", element("CueTrack", whole(1)), element("CueClusterPosition", whole(at, 8)));
      at += content[k].length;
      return element("CuePoint", element("CueTime", whole(milliseconds(group[0].time), 8)), positions);
    });
    return element("Cues", ...points);
  };
  const first = info.length + tracks.length + cues(0).length; // within the segment
  return joined([header(), element("Segment", info, tracks, cues(first), ...content)]);
}
