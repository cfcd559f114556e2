import { words } from "../i18n";
import { account } from "../i18n/account";

export const a = words(account);
