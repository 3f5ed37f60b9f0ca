// Shapes for good and bad that need no colour, in a box of 16 by 16.

export const kTick = "M2 9l4 4l8-9l-2-2l-6 7l-2-2z";
export const kDisc = "M8 2a6 6 0 1 0 0 12a6 6 0 1 0 0-12z";
export const kLine = "M2 7h12v2h-12z";
export const kTriangle = "M8 1l7 13h-14z";
export const kCross = "M3 1l5 5l5-5l2 2l-5 5l5 5l-2 2l-5-5l-5 5l-2-2l5-5l-5-5z";
